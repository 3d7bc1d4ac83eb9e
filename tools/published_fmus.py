"""Test the FMUs that others publish, and write a table for the page docs/importers.md, by hand.

    python tools/published_fmus.py FOLDER...

The folders, clones of what vendors publish, are no part of this repository. Every FMU below them with a binary for this
machine is checked against the results that it carries or has next to it. The master then runs it alone over its default
experiment, at most 1000 steps, and so does fmpy: the difference is in parts of the largest value of a column, or of
1e-6 where that is larger.
"""

import argparse
import sys
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from fmpy import supported_platforms
from fmpy.model_description import ModelDescription, read_model_description

from maglev import FmuSetup, check_fmus
from maglev.cosim.isolated_run import IsolatedRun, run_apart
from maglev.files.errors import FAILURES, in_one_line
from maglev.fmi.native_build import host_platform
from maglev.runs.experiment_check import Times, run_where_it_belongs

MOST_STEPS = 1000
SMALL = 1e-6   # what is less is rounding
TIMEOUT = 60.0   # s, of a call
HEAD = ("by", "FMU", "FMI", "its results", "master, against fmpy")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER")
    paths = sorted(path for folder in parser.parse_args().folders for path in folder.rglob("*.fmu"))
    print(f"{datetime.now(UTC):%Y-%m-%d}\n\n| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}")
    here = {*host_platform(2), *host_platform(3)}
    for path in paths:
        try:
            platforms = {*supported_platforms(str(path))}
        except Exception as error:   # of whatever an archive can be
            print(f"{path}: {in_one_line(error)}", file=sys.stderr)
            continue
        if platforms & here:
            print(f"| {' | '.join(row(path))} |", flush=True)


def row(path: Path) -> tuple[str, ...]:
    """Return the row of the table for an FMU."""
    try:
        description = read_model_description(str(path), validate=False)
    except Exception as error:
        return "", path.stem, "", "", in_one_line(error)
    kinds = [kind for kind, there in (("cs", description.coSimulation), ("me", description.modelExchange)) if there]
    return (description.generationTool or "", path.stem, f"{description.fmiVersion} {'+'.join(kinds)}", checked(path),
            compared(path, description))


def checked(path: Path) -> str:
    """Outcome of the experiments of an FMU."""
    results = check_fmus([path], timeout=TIMEOUT)
    return "; ".join(f"{result.status}: {result.message.replace(f'{path}: ', '')}" for result in results)


def compared(path: Path, description: ModelDescription) -> str:
    """Return how far a run by the master is from one by fmpy, or which of them failed, and how."""
    experiment = description.defaultExperiment
    stop = float(getattr(experiment, "stopTime", None) or 1.0)
    step = float(getattr(experiment, "stepSize", None) or stop / 500.0)
    steps = max(1, min(round(stop / step), MOST_STEPS))
    names = [v.name for v in description.modelVariables if v.causality == "output" and not v.dimensions
             and v.type not in ("String", "Binary", "Clock")]
    try:
        recording = run_apart(IsolatedRun([FmuSetup("fmu", path)], [], step, "sequential", steps * step, {}),
                              timeout=TIMEOUT)
    except FAILURES as error:
        return f"master: {in_one_line(error)}"
    if not names:
        return f"runs {steps} steps; no output to compare"
    try:
        run = run_where_it_belongs(path, Times(0.0, steps * step, step, None), {}, None, names, lambda *_: None,
                                   TIMEOUT)
    except FAILURES as error:
        return f"runs {steps} steps; fmpy: {in_one_line(error)}"
    rows = np.searchsorted(run.columns["time"], recording.time + 1e-6 * step, "right") - 1   # after an event
    worst = {name: float(np.max(np.abs(recording.columns[f"fmu.{name}"] - run.columns[name][rows]))
                         / max(SMALL, np.max(np.abs(run.columns[name])))) for name in names}
    name = max(worst, key=worst.__getitem__)
    return f"{steps} steps, " + (f"{worst[name]:.1e} ({name})" if worst[name] else "the same bits")


if __name__ == "__main__":
    main()
