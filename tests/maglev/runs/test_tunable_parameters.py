"""Signals on tunable parameters: constants of the plant that change while it moves."""

from pathlib import Path

import numpy as np
import pytest
from facts import raises
from motor import MOTOR

from maglev.cosim.master import FmuSetup, Master
from maglev.files.errors import FmuError, ScenarioError
from maglev.runs.preparation import prepare
from maglev.scenario.layers import PACKAGED
from maglev.scenario.loading import load_plan
from maglev.scenario.run_plan import RunPlan
from pmlsm.gap_functions import gap_functions

DT = 0.5e-3   # s
GAP = 0.02    # m

# Brackets hold the air gap, and nothing but the motor moves the mover.
DRIVE = """
extends = ["{folder}/loops/2dof-drive.toml", "{folder}/effects/2dof-none.toml"]
name = "drive"
title = "Drive"
stop_time = "20 ms"
[fmus.controller.start]
"motor.i_q_reference" = "-2 A"
[fmus.plant.start]
"v.locked" = true
"v.position_start" = "20 mm"
"motor.amplifier.lag" = 0
"encoder.resolution" = 0
"""
STEP = """
[[signals]]
to = "plant.{name}"
kind = "steps"
times = {times}
values = {values}
"""


def drive(folder: Path, *steps: str) -> RunPlan:
    path = folder / "drive.toml"
    path.write_text(DRIVE.format(folder=PACKAGED) + "".join(steps))
    return load_plan(path)


def accelerations(plan: RunPlan, fmus: Path) -> np.ndarray:
    """Mean acceleration of the mover over each communication step, m/s²."""
    return np.diff(prepare(plan, fmus, {}, {}).run().columns["plant.h.velocity"]) / DT


def test_thrust_changes_with_the_constant_at_that_time(either_kind: Path, tmp_path: Path) -> None:
    """h'' = −C1 f1 i_q, (4.3)."""
    plan = drive(tmp_path, STEP.format(name="C1", times="[0, 0.01, 0.015]", values="[14.2, 11.36, 28.4]"))
    expected = -np.repeat([14.2, 11.36, 28.4], [20, 10, 10]) * gap_functions(MOTOR, GAP)[0] * -2.0
    # Between two samples the mover leaves the place that the currents are commutated for: 0.3 m/s for 0.5 ms are
    # 0.01 rad of a pole pitch, and the cosine of that is 1 to 5e-5.
    assert accelerations(plan, either_kind) == pytest.approx(expected, rel=1e-4)


def test_the_first_value_goes_before_the_start_value(fmus: Path, tmp_path: Path) -> None:
    made = drive(tmp_path, STEP.format(name="C1", times="[0]", values="[7.1]"))
    halved = accelerations(made, fmus)
    assert halved == pytest.approx(0.5 * accelerations(drive(tmp_path), fmus), rel=1e-4)


def test_mass_of_an_axis_with_its_unit(either_kind: Path, tmp_path: Path) -> None:
    """C1 is the acceleration at the nominal mass: the same current pushes a thousandth of the mass a thousand times."""
    text = STEP.format(name="h.mass", times="[0]", values='["{}"]')
    light, heavy = (accelerations(drive(tmp_path, text.format(mass)), either_kind) for mass in ("1 kg", "1000 kg"))
    # The lighter mover leaves the place that the currents are commutated for a little within the sample.
    assert light[0] == pytest.approx(1000.0 * heavy[0], rel=1e-6)


def test_faults_come_and_go(either_kind: Path, tmp_path: Path) -> None:
    """Booleans: a phase is open, then the amplifiers are off, then stuck, and then it is as it was."""
    faults = [("phase_b.open", "[0, 0.004, 0.008]", "[false, true, false]"),
              ("amplifier.off", "[0, 0.008, 0.012]", "[0, 1, 0]"), ("amplifier.stuck", "[0, 0.012]", "[false, true]")]
    plan = drive(tmp_path, *(STEP.format(name=f"motor.{name}", times=times, values=values)
                             for name, times, values in faults))
    columns = prepare(plan, either_kind, {}, {}).run().columns
    a, b, c = (columns[f"plant.motor.i_{phase}"][1:] for phase in "abc")
    wanted = [columns[f"controller.motor.i_{phase}_cmd"][1:] for phase in "abc"]
    assert (b[8:24] == 0.0).all() and (b[:8] == wanted[1][:8]).all() and abs(b[:8]).min() > 0.5
    assert (a[:16] == wanted[0][:16]).all(), "amplifiers are independent"
    assert (a[16:] == 0.0).all() and (c[16:] == 0.0).all(), "off, then stuck at that"
    assert abs(wanted[0][16:]).min() > 0.1
    assert set(columns["plant.motor.amplifier.off"]) == {0, 1}, "what drives a parameter is recorded, as of an input"


@pytest.mark.parametrize(("name", "values", "facts"), [
    ("v.stop.lower", "[0.01, 0.02]", ["fixed", "tunable"]), ("h.position_start", "[0.01, 0.02]", ["fixed", "tunable"]),
    ("v.locked", "[0, 1]", ["fixed", "tunable"]), ("motor.amplifier.off", "[0, 2]", ["Boolean", "true", "false"]),
    ("C1", "[true, false]", ["Real", "numbers"]), ("C9", "[1, 2]", ["plant", "'C9'"]),
    ("h.position", "[1, 2]", ["output", "input", "parameter"]), ("h.mass", '["1 m", "2 m"]', ["m", "kg"]),
    ("motor.i_a_cmd", "[1, 2]", ['fmus.plant.inputs."motor.i_a_cmd"'])])
def test_refuses_a_fixed_parameter_by_its_name(fmus: Path, tmp_path: Path, name: str, values: str,
                                               facts: list[str]) -> None:
    plan = drive(tmp_path, STEP.format(name=name, times="[0, 0.01]", values=values))
    with raises(ScenarioError, plan.source, "signals[0].to", f"'plant.{name}'", *facts):
        prepare(plan, fmus, {}, {}).check()


def test_a_parameter_has_no_rate_and_one_source(fmus: Path, tmp_path: Path) -> None:
    step = STEP.format(name="C1", times="[0]", values="[14]")
    with raises(ScenarioError, "signals[1].to", "'plant.C1'", "signals[0].to"):
        prepare(drive(tmp_path, step, step), fmus, {}, {}).check()
    rated = step.replace('to = "plant.C1"', 'to = "plant.C1"\nrate_to = "plant.C2"')
    with raises(ScenarioError, "signals[0].rate_to", "'plant.C2'", "parameter", "input"):
        prepare(drive(tmp_path, rated), fmus, {}, {}).check()


ESTIMATOR = """
[fmus.plant.inputs]
"{name}" = "{source}"
[fmus.estimator]
model = "Estimator2DOF"
[fmus.estimator.start]
C1_start = 7.1
held = true
"""


def test_an_output_feeds_a_tunable_parameter(either_kind: Path, tmp_path: Path) -> None:
    """As a signal of the same values does, from the first step on."""
    wired = drive(tmp_path, ESTIMATOR.format(name="C1", source="estimator.C1"))
    connected = accelerations(wired, either_kind)
    signal = accelerations(drive(tmp_path, STEP.format(name="C1", times="[0]", values="[7.1]")), either_kind)
    assert (connected == signal).all()
    assert connected == pytest.approx(0.5 * accelerations(drive(tmp_path), either_kind), rel=1e-4)


def test_connections_need_inputs_or_tunable_parameters(fmus: Path, tmp_path: Path) -> None:
    """Also where nothing was checked before."""
    for name, source, *facts in (("v.stop.lower", "plant.v.position", "'v.stop.lower'", "fixed", "tunable"),
                                 ("C1", "estimator.C2", "fmus.plant.inputs.C1", "m/(s2.T2)", "m/(s2.A)"),
                                 ("h.position", "plant.v.position", "'h.position'", "output", "input", "parameter")):
        wired = drive(tmp_path, ESTIMATOR.format(name=name, source=source))
        with raises(ScenarioError, wired.source, *facts):
            prepare(wired, fmus, {}, {}).check()
    participants = [FmuSetup(name, fmus / f"{fmu.model}.fmu") for name, fmu in wired.fmus.items()]
    with (Master(participants, [("controller.motor.i_q_cmd", "plant.h.position")], DT) as master,
          raises(FmuError, "plant.h.position", "output", "input", "parameter")):
        master.run(0.01)
    with Master(participants, [], DT) as master:
        columns = master.run(0.01, {"plant.C1": [14.0] * 21}).columns
    assert set(columns["plant.C1"]) == {14.0}, "what drives a parameter is recorded, as of an input"
