"""Studies: one scenario flown many times, with what varies, what is kept of each flight, and a page about all."""
