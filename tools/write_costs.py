"""Measure every law on an emulated Cortex-M7, over the setpoints of its stage; minutes.

    python tools/write_costs.py

It writes `maglev/pages/comparison/costs.toml`, and the table between the markers of docs/target.md.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import maglev
from maglev.api.target import usual_run
from maglev.descriptions.own_fmus import DEFINITIONS, definition
from maglev.files.errors import ScenarioError
from maglev.files.marked import markdown_table, write_part

ROOT = Path(__file__).parents[1]
COSTS = ROOT / "maglev" / "pages" / "comparison" / "costs.toml"
PAGE = ROOT / "docs" / "target.md"
HEAD = "# Written by `python tools/write_costs.py`.\n"


class Cost(NamedTuple):
    """Cost of a law in a run of its stage: instructions a sample, bytes of flash, RAM and stack."""

    run: str
    least: int
    mean: int
    most: int
    flash: int
    ram: int
    stack: int


def laws() -> dict[str, str]:
    runs = {}
    for name in DEFINITIONS:
        try:
            runs[name] = str(usual_run(definition(name), None))
        except ScenarioError:
            continue
    return runs


def cost_of(name: str, run: str) -> Cost:
    with TemporaryDirectory() as folder:
        report = maglev.target(name, run, out=folder).report
    assert report is not None, "expected qemu-system-arm to be installed"
    return Cost(run, report.least, round(report.mean), report.most, report.flash, report.ram, report.stack)


def as_toml(costs: Mapping[str, Cost]) -> str:
    return HEAD + "".join(f"\n[{name}]\n" + "".join(
        f"{key} = {json.dumps(value)}\n" for key, value in cost._asdict().items()) for name, cost in costs.items())


def as_markdown(costs: Mapping[str, Cost]) -> str:
    return markdown_table(("", "instructions a sample", "least to most", "flash", "RAM", "stack"), (
        (f"`{name}`", cost.mean, f"{cost.least} to {cost.most}", f"{1e-3 * cost.flash:.1f} kB",
         f"{1e-3 * cost.ram:.1f} kB", f"{1e-3 * cost.stack:.2f} kB") for name, cost in costs.items()))


def main() -> None:
    costs = {}
    for name, run in laws().items():
        costs[name] = cost_of(name, run)
        print(name, costs[name], flush=True)
    COSTS.write_text(as_toml(costs), encoding="utf-8")
    write_part(PAGE, "costs", as_markdown(costs))


if __name__ == "__main__":
    main()
