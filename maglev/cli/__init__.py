"""The command line `maglev`: options and what is printed; what is done is in the rooms below."""
