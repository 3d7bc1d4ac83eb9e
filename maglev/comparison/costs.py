"""What the laws of this project take on a Cortex-M7: measured by `tools/write_costs.py`, and kept in `costs.toml`."""

import tomllib
from functools import cache
from importlib.resources import files
from typing import NamedTuple


class Cost(NamedTuple):
    """What a law takes on a run of its stage: instructions of a sample, bytes of flash, RAM and stack."""

    run: str
    least: int
    mean: int
    most: int
    flash: int
    ram: int
    stack: int


@cache
def costs() -> dict[str, Cost]:
    """By the name of the FMU."""
    text = files("maglev.comparison").joinpath("costs.toml").read_text(encoding="utf-8")
    return {name: Cost(**table) for name, table in tomllib.loads(text).items()}
