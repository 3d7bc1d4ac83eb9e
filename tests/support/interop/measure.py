"""Print the table of docs/interop.md, with everything built in the folder fmus.

`PYTHONPATH=.:tests/support python tests/support/interop/measure.py fmus`
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

from maglev.cosim.master import Master, Participant
from maglev.schema.scenario import Scenario

SYSTEM = "Stage3DOF"
SMOOTH = {"plant.encoder.resolution": 0.0}


def container(scenario: Scenario, fmus: Path, natives: Path) -> Rows:
    """Positions after each step of the closed loop as one FMU, under our master."""
    drives = {name.replace("controller.", "loop.", 1): values for name, values in drives_of(scenario, natives).items()}
    with Master([Participant("loop", fmus / "ClosedLoop3DOF.fmu")], [], scenario.step) as master:
        columns = master.run(scenario.stop_time, drives).columns
    return np.array([columns[f"loop.{name}"][1:] for name in positions(scenario)]).T


def row(what: str, kind: str, scenario: Scenario, rows: Rows, fmus: Path, same: Rows, note: str) -> None:
    """Print a row: largest differences of any position to our orders, m."""
    differences = [np.abs(rows - each).max() for each in
                   (ours(scenario, fmus, "sequential"), ours(scenario, fmus, "jacobi"), same)]
    print(f"| {what} | {kind}, {scenario.stop_time:g} s | "
          + " | ".join("**0**" if each == 0.0 else f"{each:.1e}" for each in differences) + f" | {note} |", flush=True)


def main(fmus: Path) -> None:
    """Run every tool with both kinds of FMUs."""
    tools = {"fmpy.ssp": f"fmpy {version('fmpy')}, `fmpy.ssp`", "ecos": f"ecos (ecospy {version('ecospy')})",
             "libcosim": f"libcosim (libcosimpy {version('libcosimpy')})"}
    natives = fmus / "native"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scenario = loop(SYSTEM, 5.0)
        row(f"container (fmu-manipulation-toolbox {version('fmu-manipulation-toolbox')})", "native", scenario,
            container(scenario, fmus, natives), natives, ours(scenario, natives, "sequential"), "")
        for kind, files, stop_time in (("native", natives, 5.0), ("Python", fmus, 5.0)):
            scenario = loop(SYSTEM, stop_time)
            ssp, closed = files / f"{SYSTEM}.ssp", files / f"{SYSTEM}NoPorts.ssp"
            row(tools["fmpy.ssp"], kind, scenario, foreign("fmpy.ssp", scenario, files, folder, ssp), files,
                ours_from_zero(scenario, files), "SSP")
            for tool, same in (("ecos", ours(scenario, files, "jacobi")),
                               ("libcosim", ours_in_nanoseconds(scenario, files))):
                for note, file in (("by hand", None), ("SSP without ports", closed)):
                    row(tools[tool], kind, scenario, foreign(tool, scenario, files, folder, file), files, same, note)
        scenario = with_start(loop(SYSTEM, 5.0), SMOOTH)
        for tool, same in (("ecos", ours(scenario, natives, "jacobi")),
                           ("libcosim", ours_in_nanoseconds(scenario, natives))):
            row(tools[tool], "native without encoder steps", scenario,
                foreign(tool, scenario, natives, folder, start=SMOOTH), natives, same, "by hand")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
