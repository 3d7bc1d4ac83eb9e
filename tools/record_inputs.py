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

# Runs with the end of what is recorded of them (s), when something happens in it (s), and the FMUs that are recorded.
RECORDED = (("2dof-setpoints", 0.3, 0.05, {"plant": "plant_2dof", "controller": "controller_2dof"}),
            ("3dof-setpoints-improved", 0.3, 0.05, {"plant": "plant_3dof", "controller": "controller_3dof"}),
            ("2dof-identification-rig", 1.0, 0.2, {"estimator_10ms": "estimator_2dof"}),
            ("3dof-identification-rig", 0.5, 0.2, {"estimator_10ms": "estimator_3dof"}))


def begun(plan: RunPlan, stop_time: float, first: float) -> RunPlan:
    """The start of a run, to a stop time (s), with the first step, or the whole excitation, at a time (s)."""
    def soon(signal: object) -> object:
        if isinstance(signal, Steps):
            return signal.model_copy(update={"times": [0.0, first, *signal.times[2:]]})
        return signal.model_copy(update={"ramp": first}) if isinstance(signal, Sinusoids) else signal

    return plan.model_copy(update={"signals": [soon(signal) for signal in plan.signals], "stop_time": stop_time})


def main() -> None:
    """Run each scenario, and write an input file for each FMU that is named."""
    for name, stop_time, first, files in RECORDED:
        experiment = prepare(begun(load_plan(name), stop_time, first), Path("fmus"), {}, {})
        recording = experiment.run()
        for fmu, file in files.items():
            described = read_description(fmu, experiment.files[fmu])
            columns = inputs_of(experiment, recording, fmu, described, lambda _, values: values)
            write_csv(SCRIPTS / f"{file}_inputs.csv", Recording(np.array(columns.pop("time")), {
                name: np.array(values) for name, values in columns.items()}))


if __name__ == "__main__":
    main()
