"""Any controller's loop analysed as it runs: derivatives by differences, frequency responses by injection."""
