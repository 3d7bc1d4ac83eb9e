"""FMUs whose blocks are compiled into one loop, in place of calls of them."""
