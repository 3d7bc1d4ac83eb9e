"""Studies: one scenario run many times, with what varies, what is kept of each run, and a page about all."""
