"""Stage and controller as one block, which steps one and then the other."""
