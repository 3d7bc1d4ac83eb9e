"""A block on a microcontroller: freestanding C, and a board in an emulator that runs it."""
