"""Experiments that an FMU carries, of ours or of anybody: read, flown, compared, and put into one."""
