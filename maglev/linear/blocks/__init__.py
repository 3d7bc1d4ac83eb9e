"""Linear models of blocks, by their derivatives."""
