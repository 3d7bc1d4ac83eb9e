"""Write the input files in scenarios/inputs: the references of a scenario, for the closed loop that is one FMU.

    python tools/write_inputs.py

There is a row at the start and at every step of a reference. The closed loops declare their references as sampled
(variability discrete), and so a tool holds a row until the time of the next, and has the new values in the step that
starts there, bit for bit those of the scenario. The time of a row is half a step before that: a clock that adds up
misses the start of a step by a rounding error, and a row at the very start would be a step early or late. Two rows at
one time, as a continuous input would need them, are not enough for that: between two rows of equal value v fmpy forms
w·v + (1 − w)·v, which is a neighbour of v for 15 % of the samples, and one rounding error of a reference is soon worth
the encoder's resolution.
"""

import numpy as np

from maglev.cosim.master import Recording
from maglev.descriptions.own_fmus import definition
from maglev.runs.experiment_pack import at_changes
from maglev.runs.results import write_csv
from maglev.scenario.layers import PACKAGED
from maglev.scenario.loading import load_plan

INPUTS = PACKAGED / "inputs"

# Closed loop and scenario of each file; the scenario's start values are those of the loop.
FILES = {"2dof-setpoints.csv": ("ClosedLoop2DOF", "2dof-setpoints"),
         "3dof-setpoints.csv": ("ClosedLoop3DOF", "3dof-setpoints-improved"),
         "5dof-setpoints.csv": ("ClosedLoop5DOF", "5dof-setpoints")}


def inputs(loop: str, name: str) -> Recording:
    """Inputs of a closed loop at the start and wherever one changes; those that the scenario does not drive are 0."""
    plan = load_plan(name)
    signals = {signal.to.partition(".")[2]: signal for signal in plan.signals}
    times = plan.step * np.arange(plan.steps + 1, dtype=np.float64)
    columns = {variable.name: signals[variable.name].values_at(times) if variable.name in signals
               else np.zeros(len(times)) for variable in definition(loop).variables if variable.causality == "input"}
    return Recording(*at_changes(times, columns, plan.step))


def main() -> None:
    for file, (loop, name) in FILES.items():
        write_csv(INPUTS / file, inputs(loop, name))


if __name__ == "__main__":
    main()
