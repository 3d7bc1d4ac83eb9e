"""Results of packaged runs that nobody simulated, with columns whose content is known."""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
import pytest
from motor import MOTOR

from controller_fmu.feedback_linearisation import equilibrium_current
from maglev.cosim.master import Recording
from maglev.descriptions.own_fmus import definition
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.runs.execution import RunResult
from maglev.scenario.loading import load_plan
from maglev.scenario.run_plan import RunPlan
from pmlsm.gap_functions import gap_functions

Simulated = Callable[..., RunResult]

CONSTANTS = {"2dof": {"C1": 13.0, "C2": 800.0, "C3": 31.5, "C4": 0.1},
             "3dof": {"C1": 0.6, "C2": 0.8, "C3": 330.0, "C4": 8.6, "C5": 0.005}}


@cache
def parameters(scenario_name: str) -> dict[str, float]:
    """Every Real parameter of a packaged run, by the blocks of its FMUs."""
    found = {}
    for name, fmu in load_plan(scenario_name).fmus.items():
        made = definition(str(fmu.model))
        block = made.new_block()
        for variable in made.variables:
            value = fmu.start[variable.name].value if variable.name in fmu.start else variable.read(block)
            if variable.causality == "parameter" and not isinstance(value, bool):
                found[f"{name}.{variable.name}"] = float(value)
    return found


def estimators_of(plan: RunPlan) -> list[str]:
    return [name for name, fmu in plan.fmus.items() if str(fmu.model).startswith("Estimator")]


def result_of(name: str, time: np.ndarray, columns: Mapping[str, Any],
              estimates: Mapping[str, Mapping[str, Any]] | None = None) -> RunResult:
    """A completed run of the package.

    Columns of the plant are named without "plant."; a number is one value at all times. Estimates are by name of the
    estimator; those that are not given have `CONSTANTS`.
    """
    plan = load_plan(name)
    full = {f"plant.{column}": values for column, values in columns.items()}
    for estimator in estimators_of(plan):
        constants = {**CONSTANTS[name[:4]], **(estimates or {}).get(estimator, {})}
        full |= {f"{estimator}.{constant}": value for constant, value in constants.items()}
    drives = {signal.to: signal.values_at(time) for signal in plan.signals}
    arrays = {column: np.broadcast_to(np.asarray(values, dtype=float), time.shape)
              for column, values in {**full, **drives}.items()}
    ends = {column: float(values[-1]) for column, values in arrays.items()}
    return RunResult(plan, Recording(time, arrays), ends=ends, parameters=dict(parameters(name)))


def staircase_of(stage: str, current_error: float = 0.0, gap_error: float = 0.0) -> RunResult:
    """The run that holds one air gap after the other, with exact currents by `CONSTANTS`; errors in A and m.

    For two thirds of the time at each air gap the mover and its current are elsewhere.
    """
    name = f"{stage}-equilibrium-currents"
    time = 5e-3 * np.arange(round(load_plan(name).stop_time / 5e-3) + 1, dtype=float)
    (signal,) = load_plan(name).signals
    asked = signal.values_at(time)
    motors = 1.0 if stage == "2dof" else 4.0
    c2, c3, c4 = (motors * value for value in list(CONSTANTS[stage].values())[-3:])
    held = {gap: equilibrium_current(MOTOR, c2, c3, c4, gap + gap_error)[0] for gap in set(asked.tolist())}
    currents = np.array([held[gap] for gap in asked.tolist()])
    moving = (time % 3.0 < 1.95) & (time < time[-1])
    position = asked + gap_error + np.where(moving, 3e-3, 0.0)
    i_d = currents + current_error + np.where(moving, 2.0, 0.0)
    axis = "v" if stage == "2dof" else "y"
    return result_of(name, time, {f"{axis}.encoder": position,
                                  **{f"{motor}.i_d": i_d for motor in PACKAGED_STAGES[stage].motor_names}})


def drive_of(name: str, thrusts: Mapping[str, float], rows: int = 2000) -> RunResult:
    """A parabola of each axis, x(t) = x(0) − ½ n L i_q t², with estimates that agree with L."""
    plan = load_plan(name)
    stage = name[:4]
    vertical, motors, drives = (("v", 1.0, {"h": ("motor", "C1", -0.05, -0.5)}) if stage == "2dof" else
                                ("y", 2.0, {"x": ("alpha", "C1", -0.06, -3.0), "z": ("beta", "C2", -0.06, -3.0)}))
    gap = float(plan.fmus["plant"].start[f"{vertical}.position_start"].value)
    time = plan.step * np.arange(rows)
    columns: dict[str, Any] = {f"{vertical}.encoder": gap}
    estimates = {}
    for axis, (motor, constant, start, i_q) in drives.items():
        thrust = thrusts.get(axis, 0.0)
        columns[f"{axis}.encoder"] = start - 0.5 * motors * thrust * i_q * time**2 if thrust else np.zeros(rows)
        columns[f"{motor}.i_q"] = i_q if thrust else 0.0
        columns[f"{motor}.i_d"] = 0.0
        estimates[constant] = thrust / gap_functions(MOTOR, gap)[0] if thrust else 0.1
    return result_of(name, time, columns, dict.fromkeys(estimators_of(plan), estimates))


@pytest.fixture(scope="session")
def simulated() -> Simulated:
    """Function that makes a run of the package; see `result_of`."""
    return result_of


@pytest.fixture(scope="session")
def staircase() -> Simulated:
    """Function that makes a run of equilibria; see `staircase_of`."""
    return staircase_of


@pytest.fixture(scope="session")
def drive() -> Simulated:
    """Function that makes a run of parabolas; see `drive_of`."""
    return drive_of


@pytest.fixture
def constants() -> dict[str, dict[str, float]]:
    """Estimates of the runs where a test gives no others, by stage."""
    return CONSTANTS
