"""Committed studies: each can be computed again from a file in this folder."""
