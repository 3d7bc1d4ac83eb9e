"""The language of blocks: a block as a typed program, its C, and its derivative."""
