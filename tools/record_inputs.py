"""Record the input files of the command lines in scenarios/scripts: what plant, controller and estimator got in a run.

    python tools/record_inputs.py

Needs the built FMUs in the folder fmus. For plants and controllers the start of the set-point experiments is recorded,
with the first step moved to 0.05 s, so that the files stay small and the plants, unstable without feedback, do not run
away from the recording. For the estimators it is the start of Procedure 4, with an excitation that is there sooner.

The rows are at the communication points: these inputs are continuous, so that tools interpolate between the rows, and a
clock that misses a point by a rounding error gets the values of its row but for a rounding error.
"""

from pathlib import Path

import numpy as np

from maglev.cosim.master import Recording
from maglev.cosim.open import read_description
from maglev.experiment.preparation import prepare
from maglev.experiment.results import write_csv
from maglev.fmu_experiments.pack import inputs_of
from maglev.schema.layers import PACKAGED
from maglev.schema.loading import load_plan
from maglev.schema.run_plan import RunPlan
from maglev.schema.signals.kinds import Sinusoids, Steps

SCRIPTS = PACKAGED / "scripts"
STOP_TIME = 0.3    # s
STEP_TIME = 0.05   # s
RAMP = 0.2         # s

PAIRS = {"2dof": "2dof-setpoints", "3dof": "3dof-setpoints-improved"}
ESTIMATED = {"2dof": ("2dof-identification-rig", 1.0), "3dof": ("3dof-identification-rig", 0.5)}   # and stop time, s


def early(plan: RunPlan) -> RunPlan:
    """The start of a set-point experiment, with an early first step."""
    signals = [signal.model_copy(update={"times": [0.0, STEP_TIME, *signal.times[2:]]})
               if isinstance(signal, Steps) else signal for signal in plan.signals]
    return plan.model_copy(update={"signals": signals, "stop_time": STOP_TIME})


def excited(plan: RunPlan, stop_time: float) -> RunPlan:
    """The start of Procedure 4, to a stop time (s), with the excitation ramped in at once."""
    signals = [signal.model_copy(update={"ramp": RAMP}) if isinstance(signal, Sinusoids) else signal
               for signal in plan.signals]
    return plan.model_copy(update={"signals": signals, "stop_time": stop_time})


def record(plan: RunPlan, files: dict[str, Path]) -> None:
    """Run a scenario and write an input file for each FMU that is named."""
    experiment = prepare(plan, Path("fmus"), {}, {})
    recording = experiment.run()
    for fmu, path in files.items():
        described = read_description(fmu, experiment.files[fmu])
        columns = inputs_of(experiment, recording, fmu, described, lambda _, values: values)
        write_csv(path, Recording(np.array(columns.pop("time")), {name: np.array(values)
                                                                  for name, values in columns.items()}))


def main() -> None:
    """Write an input file for each plant, each controller and each estimator."""
    for rig, name in PAIRS.items():
        files = {fmu: SCRIPTS / f"{fmu}_{rig}_inputs.csv" for fmu in ("plant", "controller")}
        record(early(load_plan(name)), files)
    for rig, (name, stop_time) in ESTIMATED.items():
        record(excited(load_plan(name), stop_time), {"estimator_10ms": SCRIPTS / f"estimator_{rig}_inputs.csv"})


if __name__ == "__main__":
    main()
