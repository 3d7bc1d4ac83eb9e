"""Processes next to this one, tasks in them, how many can run at a time, and the interrupts that end them."""

import os

from maglev.files.errors import ScenarioError
from maglev.files.units import whole_number


def processors(asked: int | None = None, name: str = "jobs") -> int:
    """How many processes or threads: as many as `asked`, or as this process has processors.

    ScenarioError, which begins with the name, if it is no number of them.
    """
    if asked is not None:
        return whole_number(asked, ScenarioError, name)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
