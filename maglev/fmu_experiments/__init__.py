"""Experiments that an FMU carries, of ours or of anybody: read, run, compared, and put into one."""
