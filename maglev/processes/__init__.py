"""Processes beside this one, tasks in them, how many can run at a time, and the interrupts that end them."""

import os


def processors() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
