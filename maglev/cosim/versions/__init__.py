"""Versions of FMI: what differs between FMUs of one and the other."""
