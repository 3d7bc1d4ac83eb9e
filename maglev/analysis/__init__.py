"""Any controller's loop analysed as it flies: derivatives by differences, frequency responses by injection."""
