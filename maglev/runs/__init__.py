"""One run: prepared, executed, measured, judged, and compared with its baseline."""
