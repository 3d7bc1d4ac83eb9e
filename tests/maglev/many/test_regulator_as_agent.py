"""A controller as an agent is what it is in a run."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from environments import STAGE_NAMES, same_bits

import maglev
from maglev.cosim.fmu import Buffer, Fmu, read_description
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.user.source import FmuFile
from pmlsm.stage_description import StageDescription

Make = Callable[..., Any]


class Controller:
    """A controller FMU of ours as an agent."""

    def __init__(self, stage: StageDescription, name: str, folder: Path):
        path = folder / "native" / f"{name}.fmu"
        self.fmu = Fmu(name, FmuFile(path), read_description(name, path))
        self.fmu.initialise({}, 0.0, 100.0)
        self.stage, self.sample = stage, 0

        def buffer(names: list[str]) -> Buffer:
            return Buffer("Real", [self.fmu.variable(name) for name in names], self.fmu.fmi)

        measured = [f"{axis.name}.measured" for axis in stage.measured]
        measured += [f"{motor}.gap_measured" for motor in stage.motor_names if stage.rotations]
        self.inputs = buffer([*measured, *(f"{axis}.reference" for axis in stage.axis_names)])
        self.measured = len(measured)
        self.dq = buffer([f"{motor}.{current}_cmd" for motor in stage.motor_names for current in ("i_d", "i_q")])
        self.phases = buffer([f"{motor}.i_{phase}_cmd" for motor in stage.motor_names for phase in "abc"])

    def action(self, observation: np.ndarray, phases: bool) -> np.ndarray:
        """Currents at an observation."""
        self.inputs.values[:] = [*observation[:self.measured], *observation[-len(self.stage.axes):]]
        self.fmu.set(self.inputs)
        step = self.stage.sample_time
        assert self.fmu.instance is not None
        self.fmu.instance.doStep(self.sample * step, step)
        self.sample += 1
        chosen = self.phases if phases else self.dq
        self.fmu.get(chosen)
        return np.array(chosen.values)


BASES = {"2dof": ["loops/2dof.toml", "references/2dof-setpoints.toml"],
         "3dof": ["loops/3dof.toml", "references/3dof-setpoints.toml"], "5dof": ["5dof-setpoints.toml"]}
SETPOINTS = """
extends = {bases}
name = "setpoints"
title = "The first step of a sequence"
stop_time = "1.5 s"
output_interval = "{interval}"
"""


@pytest.mark.few(3)
@pytest.mark.parametrize("stage", STAGE_NAMES)
@pytest.mark.parametrize(("action", "measured"), [("dq", False), ("phases", False), ("dq", True), ("phases", True)])
def test_regulator_runs_as_in_a_run(make: Make, folder: Path, tmp_path: Path, stage: str, action: str,
                                     measured: bool) -> None:
    """The regulator as an agent gives the positions of `maglev.run` bit for bit; behind a measurement, too."""
    of = PACKAGED_STAGES[stage]
    scenario = tmp_path / "setpoints.toml"
    bases = [*BASES[stage], *([f"loops/{stage}-measurement.toml"] if measured else [])]
    scenario.write_text(SETPOINTS.format(bases=bases, interval=f"{1e3 * of.sample_time:g} ms"), encoding="utf-8")
    changed = {f"plant.{of.horizontal[0].name}.friction.coulomb": 0.2}
    errors = {"seed": 7.0, "delay": 2.0 * of.sample_time, f"{of.horizontal[0].name}.noise": 2e-6} if measured else None
    run = maglev.run(scenario, fmus=folder, kind="native",
                     set={**changed, **{f"measurement.{name}": value for name, value in (errors or {}).items()}})
    references = np.column_stack([run[f"controller.{axis}.reference"] for axis in of.axis_names])
    env = make(stage, action=action, reference=references, duration="1.5 s", measurement=errors,
               **{name.removeprefix("plant."): value for name, value in changed.items()})
    controller = Controller(of, f"Regulator{stage.upper()}", folder)
    observation, _ = env.reset()
    positions = [env.compiled.positions.copy()]
    truncated = False
    while not truncated:
        observation, _, terminated, truncated, _ = env.step(controller.action(observation, action == "phases"))
        assert not terminated
        positions.append(env.compiled.positions.copy())
    controller.fmu.close()
    expected = np.column_stack([run[f"plant.{axis}.position"] for axis in of.axis_names])
    assert same_bits(np.array(positions), np.ascontiguousarray(expected))
    assert np.ptp(expected, axis=0).min() > 1e-3, "something has to move for this to mean anything"
