"""Committed studies: what was computed once, and can be again, from a file in this folder."""
