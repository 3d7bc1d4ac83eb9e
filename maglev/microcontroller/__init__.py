"""Controllers on a microcontroller: their C, a Cortex-M7 in an emulator that runs it, and what it takes there."""
