"""The closed loops that foreign masters run, and what they give."""

import json
import subprocess
import sys
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from unittest import mock
from zipfile import ZipFile

import numpy as np
import pytest
from interop import foreign_masters
from numpy.typing import NDArray
from sampled_loop import sampled_loop

from maglev.cosim import Order
from maglev.cosim.master import FmuSetup, Master
from maglev.cosim.wiring import Wiring, wire
from maglev.descriptions.own_fmus import SYSTEMS
from maglev.runs.preparation import prepare
from maglev.scenario.loading import load_plan
from maglev.scenario.run_plan import RunPlan, StartValue
from maglev.user.source import FmuFile

PACKAGES = {"fmpy.ssp": "fmpy", "ecos": "ecospy", "libcosim": "libcosimpy"}
LONGEST_RUN = 300.0   # s, of a foreign master's process

Rows = NDArray[np.float64]


def require_tool(tool: str) -> None:
    """Skip where a foreign master is not installed."""
    if find_spec(PACKAGES[tool]) is None:
        pytest.skip(f"{PACKAGES[tool]} is not installed (extra `interop`)")


def loop(system: str, stop_time: float) -> RunPlan:
    """Scenario of a system with the references of its stage's setpoints, for the first seconds."""
    return load_plan(SYSTEMS[system]).model_copy(update={"stop_time": stop_time})


def positions(plan: RunPlan) -> list[str]:
    """Names of the axes' positions."""
    return [axis.position for axis in plan.axes.values()]


def drives_of(plan: RunPlan, fmus: Path) -> dict[str, list[float]]:
    """References and their rates at every communication point, the last included."""
    experiment = prepare(plan, fmus, {}, {})
    return {name: values.tolist() for name, values in experiment.drives(experiment.check()).items()}


def ours(plan: RunPlan, fmus: Path, order: Order) -> Rows:
    """Positions after each step under our master."""
    recording = prepare(plan, fmus, {}, {}, {"order": order}).run()
    return np.array([recording.columns[name][1:] for name in positions(plan)]).T


def with_start(plan: RunPlan, start: Mapping[str, float]) -> RunPlan:
    """Scenario with further start values, `fmu.variable`."""
    fmus = {name: fmu.model_copy(update={"start": fmu.start | {
        full.partition(".")[2]: StartValue(value, None, str(value)) for full, value in start.items()
        if full.partition(".")[0] == name}}) for name, fmu in plan.fmus.items()}
    return plan.model_copy(update={"fmus": fmus})


def foreign(tool: str, plan: RunPlan, fmus: Path, folder: Path, ssp: Path | None = None,
            start: Mapping[str, float] | None = None) -> Rows:
    """Positions after each step under a foreign master; skips where it cannot be loaded."""
    require_tool(tool)
    request: foreign_masters.Request = {
        "fmus": {name: str(fmus / f"{fmu.model}.fmu") for name, fmu in plan.fmus.items()},
        "connections": [(source, target) for source, target in plan.wires.values()],
        "step": plan.step,
        "drives": {name: values[:-1] for name, values in drives_of(plan, fmus).items()},
        "record": positions(plan),
        "start": dict(start or {}),
        "ssp": None if ssp is None else str(ssp),
    }
    asked, result = folder / "request.json", folder / "rows.npy"
    asked.write_text(json.dumps(request), encoding="utf-8")
    result.unlink(missing_ok=True)
    done = subprocess.run([sys.executable, foreign_masters.__file__, tool, asked, result], capture_output=True,
                          timeout=LONGEST_RUN)
    said = done.stderr.decode("utf-8", "replace").strip()
    if done.returncode == foreign_masters.CANNOT_LOAD:
        pytest.skip(said.splitlines()[-1])
    if done.returncode != 0:
        raise ForeignMasterFailed(f"{tool} ended with {done.returncode}: {said[-2000:]}")
    rows: Rows = np.load(result)
    return rows


class ForeignMasterFailed(RuntimeError):
    """A foreign master that did not complete a run."""


def ours_from_zero(plan: RunPlan, fmus: Path, system: Path | None = None) -> Rows:
    """Positions after each step under our master in Jacobi order, with the exchange of fmpy's SSP simulation.

    Every input is 0.0 before the first step, and the references, which come through ports of the system, are a step
    late. FMUs are those of a system, if there is one: what is a parameter elsewhere may be an input there.
    """
    def without_exchange(*arguments: Any) -> Wiring:
        return wire(*arguments)._replace(initial=[])

    experiment = prepare(plan, fmus, {}, {})
    drives = {name: [0.0, *values[:-1]] for name, values in experiment.drives(experiment.check()).items()}
    participants = [FmuSetup(setup.name, setup.source) if system is None else
                    FmuSetup(setup.name, files_in(system, setup), setup.start, setup.ports)
                    for setup in experiment.setups()]
    with (mock.patch("maglev.cosim.master.wire", without_exchange),
          Master(participants, list(plan.wires.values()), plan.step, "jacobi") as master):
        recording = master.run(plan.stop_time, drives)
    return np.array([recording.columns[name][1:] for name in positions(plan)]).T


def files_in(system: Path, setup: FmuSetup) -> Path:
    """File of an FMU of a system, next to it."""
    assert isinstance(setup.source, FmuFile)
    names = (setup.source.name, f"{setup.source.path.stem}_{setup.name}.fmu")
    with ZipFile(system) as archive:
        return Path(archive.extract(next(name for name in archive.namelist() if Path(name).name in names),
                                    system.parent))


def ours_in_nanoseconds(plan: RunPlan, fmus: Path) -> Rows:
    """Positions after each step of the blocks in Jacobi order, with the steps of libcosim.

    Its times are whole nanoseconds, and a step is the difference of two times in seconds, rounded to doubles each.
    """
    step = round(plan.step * 1e9)
    points = [k * step / 1e9 for k in range(plan.steps + 1)]
    names = positions(plan)
    columns = sampled_loop(plan, drives_of(plan, fmus), names, points[:-1], np.diff(points).tolist(), "jacobi")
    return np.array([columns[name][1:] for name in names]).T
