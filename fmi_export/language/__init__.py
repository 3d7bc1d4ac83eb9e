"""The language of blocks: a block's instance and its methods, as a typed program, and its C."""
