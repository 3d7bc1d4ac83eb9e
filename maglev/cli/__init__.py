"""The command line `maglev`: options and output; the work is done in the packages below."""
