"""Print the table of docs/importing.md, with everything built in the folder fmus.

`PYTHONPATH=tests/support python benchmarks/foreign_masters_table.py fmus`
"""

import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

import numpy as np
from interop.loops import (
    Rows,
    drives_of,
    foreign,
    loop,
    ours,
    ours_from_zero,
    ours_in_nanoseconds,
    positions,
    with_start,
)

from maglev.cosim.master import FmuSetup, Master
from maglev.schema.run_plan import RunPlan

SYSTEM = "Stage3DOF"
SMOOTH = {"plant.encoder.resolution": 0.0}


def one_fmu(plan: RunPlan, fmus: Path) -> Rows:
    """Positions after each step of the closed loop as one FMU, under our master."""
    drives = {name.replace("controller.", "loop.", 1): values for name, values in drives_of(plan, fmus).items()}
    with Master([FmuSetup("loop", fmus / "ClosedLoop3DOF.fmu")], [], plan.step) as master:
        columns = master.run(plan.stop_time, drives).columns
    return np.array([columns[f"loop.{name}"][1:] for name in positions(plan)]).T


def row(what: str, kind: str, plan: RunPlan, rows: Rows, fmus: Path, same: Rows, note: str) -> None:
    """Print a row: largest differences of any position to our orders, m."""
    differences = [np.abs(rows - each).max() for each in
                   (ours(plan, fmus, "sequential"), ours(plan, fmus, "jacobi"), same)]
    print(f"| {what} | {kind}, {plan.stop_time:g} s | "
          + " | ".join("**0**" if each == 0.0 else f"{each:.1e}" for each in differences) + f" | {note} |", flush=True)


def main(fmus: Path) -> None:
    """Run every tool with both kinds of FMUs."""
    tools = {"fmpy.ssp": f"fmpy {version('fmpy')}, `fmpy.ssp`", "ecos": f"ecos (ecospy {version('ecospy')})",
             "libcosim": f"libcosim (libcosimpy {version('libcosimpy')})"}
    natives = fmus / "native"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for kind, files, stop_time in (("native", natives, 5.0), ("Python", fmus, 5.0)):
            plan = loop(SYSTEM, stop_time)
            ssp, closed = files / f"{SYSTEM}.ssp", files / f"{SYSTEM}NoPorts.ssp"
            row("any: the loop is one FMU", kind, plan, one_fmu(plan, files), files, ours(plan, files, "sequential"),
                "`ClosedLoop3DOF.fmu`")
            row(tools["fmpy.ssp"], kind, plan, foreign("fmpy.ssp", plan, files, folder, ssp), files,
                ours_from_zero(plan, files), "SSP")
            for tool, same in (("ecos", ours(plan, files, "jacobi")),
                               ("libcosim", ours_in_nanoseconds(plan, files))):
                for note, file in (("by hand", None), ("SSP without ports", closed)):
                    row(tools[tool], kind, plan, foreign(tool, plan, files, folder, file), files, same, note)
        plan = with_start(loop(SYSTEM, 5.0), SMOOTH)
        for tool, same in (("ecos", ours(plan, natives, "jacobi")),
                           ("libcosim", ours_in_nanoseconds(plan, natives))):
            row(tools[tool], "native without encoder steps", plan,
                foreign(tool, plan, natives, folder, start=SMOOTH), natives, same, "by hand")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
