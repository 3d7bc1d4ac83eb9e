"""Stages as data: their descriptions, their FMUs, and their closed loops."""
