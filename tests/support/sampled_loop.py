"""The blocks of a scenario called directly, in the order of the master: what every run must equal, bit for bit."""

from array import array
from collections.abc import Mapping, Sequence
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maglev.cosim import Order
from maglev.own_fmus import definition
from maglev.rig.rigs import RIGS
from maglev.schema.run_plan import RunPlan

PHASES = ("i_a_cmd", "i_b_cmd", "i_c_cmd")


def set_path(block: Any, name: str, value: float | bool) -> None:
    """Set an attribute path of a block."""
    path, _, attribute = name.rpartition(".")
    setattr(attrgetter(path)(block) if path else block, attribute, value)


def sampled_loop(plan: RunPlan, drives: Mapping[str, Sequence[float] | NDArray[np.float64]], names: Sequence[str],
                 times: Sequence[float], steps: Sequence[float],
                 order: Order = "sequential") -> dict[str, NDArray[np.float64]]:
    """Values of `fmu.variable` names before the first step and after each, at times t_k (s) and with steps h_k (s)."""
    rig = RIGS[plan.name.partition("-")[0]]
    blocks: dict[str, Any] = {}
    for fmu, table in plan.fmus.items():
        blocks[fmu] = definition(str(table.model)).new_block()
        for name, start in table.start.items():
            set_path(blocks[fmu], name, start.value)
        assert blocks[fmu].start() == 0
    controller, plant = blocks["controller"], blocks["plant"]

    def command() -> None:
        for motor in rig.motor_names:
            for phase in PHASES:
                setattr(getattr(plant, motor), phase, getattr(getattr(controller, motor), phase))

    getters = {name: attrgetter(name.partition(".")[2]) for name in names}
    rows = {name: array("d") for name in names}
    for k, (t, h) in enumerate(zip([*times, 0.0], [*steps, 0.0], strict=True)):
        for name in names:
            rows[name].append(getters[name](blocks[name.partition(".")[0]]))
        if k == len(times):
            break
        for target, values in drives.items():
            set_path(controller, target.partition(".")[2], values[k])
        for axis in rig.axis_names:
            getattr(controller, axis).measured = getattr(plant, axis).encoder
        if order == "jacobi":
            command()   # what the controller has given in the step before
        assert controller.step(t, h) == 0
        if order == "sequential":
            command()
        assert plant.step(t, h) == 0
    return {name: np.frombuffer(values) for name, values in rows.items()}
