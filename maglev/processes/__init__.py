"""Processes beside this one, tasks in them, how many can run at a time, and the interrupts that end them."""

import os

from maglev.errors import ScenarioError


def processors(asked: int | None = None, name: str = "jobs") -> int:
    """How many processes or threads: as many as `asked`, or as this process has processors.

    ScenarioError, which begins with the name, if fewer than one are asked for.
    """
    if asked is not None:
        if asked < 1:
            raise ScenarioError(f"{name} = {asked}, expected at least 1")
        return asked
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
