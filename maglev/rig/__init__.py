"""Stages: their descriptions read from files, and the blocks and FMUs written from them."""
