"""The experiments: scenario files, master, metrics, claims and the command line."""
