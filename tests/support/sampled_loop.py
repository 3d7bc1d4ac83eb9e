"""The blocks of a scenario called directly, in the order of the master: what every run must equal, bit for bit."""

from array import array
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maglev.cosim import Order
from maglev.descriptions.own_fmus import definition
from maglev.fmi.definition import Variable
from maglev.scenario.run_plan import RunPlan

PHASES = ("i_a_cmd", "i_b_cmd", "i_c_cmd")


def sampled_loop(plan: RunPlan, drives: Mapping[str, Sequence[float] | NDArray[np.float64]], names: Sequence[str],
                 times: Sequence[float], steps: Sequence[float],
                 order: Order = "sequential") -> dict[str, NDArray[np.float64]]:
    """Values of `fmu.variable` names before the first step and after each, at times t_k (s) and with steps h_k (s)."""
    blocks: dict[str, Any] = {}
    variables: dict[str, Variable] = {}
    for fmu, table in plan.fmus.items():
        of = definition(str(table.model))
        blocks[fmu] = of.new_block()
        variables |= {f"{fmu}.{v.name}": v for v in of.variables}
        for name, start in table.start.items():
            variables[f"{fmu}.{name}"].write(blocks[fmu], start.value)
        assert blocks[fmu].start() == 0
    controller, plant = blocks["controller"], blocks["plant"]

    def command() -> None:
        for given, commanded in zip(plant.motors, controller.motors, strict=True):
            for phase in PHASES:
                setattr(given, phase, getattr(commanded, phase))

    rows = {name: array("d") for name in names}
    for k, (t, h) in enumerate(zip([*times, 0.0], [*steps, 0.0], strict=True)):
        for name in names:
            rows[name].append(variables[name].read(blocks[name.partition(".")[0]]))
        if k == len(times):
            break
        for target, values in drives.items():
            variables[target].write(controller, values[k])
        for seen, axis in zip(controller.axes, plant.axes, strict=True):
            seen.measured = axis.encoder
        if order == "jacobi":
            command()   # what the controller has given in the step before
        assert controller.step(t, h) == 0
        if order == "sequential":
            command()
        assert plant.step(t, h) == 0
    return {name: np.frombuffer(values) for name, values in rows.items()}
