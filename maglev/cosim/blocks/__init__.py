"""FMUs whose blocks are compiled into one loop, in place of calls of them; what is around the blocks lies here as C."""
