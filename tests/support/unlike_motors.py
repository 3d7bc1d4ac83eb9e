"""Stages whose motors are not alike: what a description says of one, and a run of such a stage."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from named_blocks import named_block

from maglev.user.new_controller import new_controller, new_plant
from maglev.user.scenario_loop import setpoints
from maglev.user.source import PythonFile
from pmlsm.stage_description import StageDescription

THOROUGH = [pytest.param(law, marks=pytest.mark.thorough) for law in ("Linear", "PID")]


def tables(drawing: Mapping[str, float], sheet: Mapping[str, float], field: tuple[float, float]) -> str:
    """What a description says of a motor of its own; its field is so large (T) and decays over a distance (m)."""
    geometry, catalogue = (", ".join(f"{key} = {value}" for key, value in of.items()) for of in (drawing, sheet))
    return (f"geometry = {{ {geometry} }}\ncatalogue = {{ currents = \"peak\", {catalogue} }}\n"
            f"field = {{ lower = 0.007, upper = 0.04, B0 = {field[0]}, decay = {field[1]} }}\n")


def given_separately(common: Path, twice: Path, motors: tuple[str, ...]) -> Path:
    """A description as another one, in which every motor says of itself what all have in common there."""
    text = common.read_text(encoding="utf-8").replace(common.stem, twice.stem)
    own = {key: text[text.index(f"\n[{key}]"):].split("\n\n")[0].replace(f"[{key}]", f"[motors.{{}}.{key}]")
           for key in ("geometry", "catalogue", "field")}
    twice.write_text(text + "".join(part.format(motor) for motor in motors for part in own.values()), encoding="utf-8")
    return twice


def simulated(stage: StageDescription, law: str, samples: int, side: float = 1.0, **plant: float) -> tuple[np.ndarray,
                                                                                                           Any]:
    """Positions at setpoints that all axes go to, tilts to one side or the other, and the closed loop after that."""
    loop: Any = named_block(f"ClosedLoop{law}{stage.suffix}")
    for name, value in plant.items():
        setattr(loop.plant, name, value)
    assert loop.start() == 0
    rows = []
    for k in range(3):
        for axis, values in setpoints(stage).items():
            getattr(loop.controller, axis).reference = 1e-3 * values[k] * (side if stage.axis(axis).rotation else 1.0)
        for _ in range(samples // 2):
            assert loop.step(0.0, 1e-2) == 0
            rows.append([getattr(loop.plant, axis).position for axis in stage.axis_names])
            assert not loop.plant.at_stop
    return np.array(rows), loop


def first_files(stage: Path, description: StageDescription, at: list[float], off: list[float]) -> tuple[np.ndarray,
                                                                                                        ...]:
    """What a stage's first controller demands at a place, how far off its references, and what comes of it.

    Accelerations that it demands, its currents (motors, 2), and accelerations of the first plant under these.
    """
    controller, plant = (PythonFile(make(stage.with_name(file), str(stage))).load().definition.new_block().law
                         for make, file in ((new_controller, "law.py"), (new_plant, "mover.py")))
    for axis, position, error in zip(description.axis_names, at, off, strict=True):
        getattr(controller, axis).measured = getattr(plant, axis).position_start = position
        getattr(controller, axis).reference = position - error
    for motor in description.motor_names:
        setattr(controller, f"{motor}_gap_measured", at[0])   # of a platform that is level
    for law in (controller, plant):
        law.start()
    controller.step(0.0)
    demands = [-2.8 * getattr(controller, axis).bandwidth**2 * error
               for axis, error in zip(description.axis_names, off, strict=True)]
    currents = []
    for motor in description.motor_names:
        command, of = getattr(controller, motor), getattr(plant, motor)
        of.i_a_cmd, of.i_b_cmd, of.i_c_cmd = command.i_a_cmd, command.i_b_cmd, command.i_c_cmd
        currents.append([command.i_d_cmd, command.i_q_cmd])
    plant.step(0.0, 1e-6)
    return (np.array(demands), np.array(currents),
            np.array([1e6 * getattr(plant, axis).velocity for axis in description.axis_names]))
