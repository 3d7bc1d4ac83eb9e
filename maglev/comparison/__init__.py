"""Runs beside each other: a table of what was measured on each, pictures that lie over each other, and a page."""
