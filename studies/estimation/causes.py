"""Other causes that a printed number might have: plants, amplifiers and encoders that differ in one thing."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from maglev.experiment.execution import RunResult, fly
from maglev.judging.metrics import evaluate
from maglev.judging.run_claims import judge_run
from maglev.schema.layers import PACKAGED
from maglev.schema.loading import load_plan
from maglev.schema.run_plan import RunPlan
from studies.estimation.evidence import Judged
from studies.estimation.flights import prepare

DEAD_TIMES = (0.001, 0.002, 0.004)   # s, of the amplifiers
GAINS = {"2dof": "gains/2dof.toml", "3dof": "gains/3dof-first.toml"}   # of the sinusoids
HEAD = 'name = "{name}"\ntitle = "A cause"\ndescription = "A cause."\n'
# The reference of the sinusoids widens the stops of y, which are at the motors where the platform tilts.
TILTING = HEAD + 'stop_time = "16 s"\n\n[fmus.plant.start]\n' + "".join(
    f'"{motor}.stop.{side}" = "{place} mm"\n' for motor in ("alpha1", "alpha2", "beta1", "beta2")
    for side, place in (("lower", 12), ("upper", 37)))
TILTING_LAYERS = ("loops/5dof-guided.toml", "effects/5dof-guides.toml", GAINS["3dof"])


def run_with(text: str, extends: Sequence[str], name: str) -> RunResult:
    """Fly a scenario that is written for this."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.toml"
        path.write_text(f"extends = {[*extends]}\n".replace("'", '"') + text, encoding="utf-8")
        return fly(prepare([str(path)])[0])


def ahead(plan: RunPlan, result: RunResult, dead_time: float) -> RunResult:
    """The run as that of a loop whose commands, not whose measurements, are late by the dead time.

    A controller that gets its measurements later acts on what it would have seen then, on references that are by as
    much ahead of it: the mover follows those.
    """
    late = round(dead_time / plan.step) // plan.output_every
    columns = {name: np.asarray(values)[:len(result.time) - late] for name, values in result.columns.items()}
    for axis in plan.axes.values():
        columns[axis.reference] = np.asarray(result.columns[axis.reference])[late:]
    return replace(result, metrics=evaluate(plan, result.time[:len(result.time) - late], columns))


def causes() -> Iterator[tuple[str, list[Judged]]]:
    """Runs of the nonlinear regulator with each cause: what it is in words, and the judged claims."""
    for dead_time in DEAD_TIMES:
        judged = []
        late = HEAD.format(name="late") + f'\n[fmus.measurement.start]\ndelay = "{dead_time} s"\n'
        for rig, reference, name in (("2dof", "tracking", "2dof-tracking-nonlinear"),
                                     ("3dof", "tracking", "3dof-tracking-nonlinear"),
                                     ("2dof", "setpoints", "2dof-setpoints")):
            flown = run_with(late, [f"loops/{rig}.toml", GAINS[rig], f"references/{rig}-{reference}.toml",
                                    f"loops/{rig}-measurement.toml"], "late")
            judged += judged_as(name, ahead(flown.plan, flown, dead_time))
        yield f"dead time of the amplifiers of {1e3 * dead_time:g} ms", judged
    flown = run_with(tilting_text(), TILTING_LAYERS, "tilting")
    yield "tilts, with compliant guides", judged_as("3dof-tracking-nonlinear", flown)


def tilting_text() -> str:
    """The sinusoids of the 3-DOF stage for the one that tilts."""
    signals = (PACKAGED / "references" / "3dof-tracking.toml").read_text(encoding="utf-8")
    return TILTING.format(name="tilting") + signals[signals.index("[[signals]]"):]


def judged_as(name: str, flown: RunResult) -> list[Judged]:
    """Claims about a run of the package, judged on another one; comparisons are not."""
    claims = [claim for claim in load_plan(name).claims if claim.figure is None and not claim.comparative]
    return [Judged(name, result) for result in judge_run(claims, flown.metrics, {})]
