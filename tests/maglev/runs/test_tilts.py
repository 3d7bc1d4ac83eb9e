"""Procedures 1 and 2 on the 5-DOF stage, without friction and bias: its own constants, by the gaps at its motors."""

from pathlib import Path

import pytest
from named_stage import Stage5DOF

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.runs.chain import prepare_all
from maglev.runs.execution import execute_all
from maglev.runs.procedure_outcome import Outcome
from maglev.runs.procedures import evaluate_all
from maglev.scenario.layers import PACKAGED
from maglev.scenario.loading import load_plans
from pmlsm.gap_functions import gap_functions

MOTORS = PACKAGED_STAGES["5dof"].motor_names
SMOOTH = "".join(f'"{axis}.{effect}" = 0\n' for axis in PACKAGED_STAGES["5dof"].axis_names
                 for effect in ("bias", "friction.coulomb", "friction.viscous")) + '"y.ripple.amplitude" = 0\n'
ESTIMATOR = """
[fmus.estimator]
model = "Estimator5DOF"

[fmus.estimator.start]
epsilon = "0.01 s"

[fmus.estimator.inputs]
"x.measured" = "plant.x.encoder"
"z.measured" = "plant.z.encoder"
""" + "".join(f'"{motor}.gap_measured" = "plant.{motor}.gap_encoder"\n'
              + "".join(f'"{motor}.i_{part}" = "plant.{motor}.i_{part}"\n' for part in "dq") for motor in MOTORS)

EQUILIBRIUM = """
extends = "{folder}/loops/5dof.toml"
name = "held"
title = "Air gaps that are held, and the vertical axis excited"

[procedure]
kind = "equilibrium"
name = "equilibrium"
title = "Equilibrium currents"
runs = {{ currents = "held-currents", excitation = "held-excitation" }}

[fmus.plant.start]
{smooth}
"x.locked" = true
"z.locked" = true
"roll.position_start" = "2 mrad"

[variants.currents]
stop_time = "6 s"

[[variants.currents.signals]]
to = "controller.y.reference"
kind = "steps"
unit = "mm"
times = [0, 3]
values = [25, 23]

[variants.excitation]
extends = "{folder}/references/3dof-excitation-vertical.toml"
stop_time = "8 s"
""" + ESTIMATOR.replace("[fmus", "[variants.excitation.fmus").replace("{", "{{").replace("}", "}}")

PARABOLA = """
extends = "{folder}/loops/5dof-drive.toml"
name = "parabola"
title = "A parabola of z at a held air gap"
stop_time = "0.4 s"

[procedure]
kind = "parabolas"
name = "parabolas"
title = "Thrust"

[fmus.plant.start]
{smooth}
"y.locked" = true
"x.locked" = true
"roll.locked" = true
"pitch.locked" = true
"z.position_start" = "-40 mm"

[fmus.controller.start]
"beta1.i_q_reference" = "-2 A"
"beta2.i_q_reference" = "-2 A"
""" + ESTIMATOR.replace("{", "{{").replace("}", "}}")


def outcome_of(folder: Path, name: str, text: str, fmus: Path) -> Outcome:
    """What the procedure of a scenario finds."""
    path = folder / f"{name}.toml"
    path.write_text(text.format(folder=PACKAGED, smooth=SMOOTH), encoding="utf-8")
    results = execute_all(prepare_all(load_plans(path), fmus, {}, {}), folder, "csv", 1, lambda *_: None)
    assert [result.failure for result in results] == [None] * len(results)
    (found,) = evaluate_all(results)
    return found


def test_equilibrium_currents_by_the_gaps_at_the_motors(fastest_fmus: Path, tmp_path: Path) -> None:
    found = outcome_of(tmp_path, "held", EQUILIBRIUM, fastest_fmus)
    constants = {value.constant: value.value for value in found.values if value.name == "constant"}
    stage = Stage5DOF()
    assert constants["C3"] == pytest.approx(stage.C3, rel=2e-3)
    assert constants["C4"] == pytest.approx(stage.C4, rel=2e-3)
    deviations = [value.value for value in found.values if value.name == "equilibrium_deviation"]
    assert len(deviations) == 2
    assert max(deviations) < 2e-3   # A


def test_thrust_by_a_parabola(fastest_fmus: Path, tmp_path: Path) -> None:
    """L = C2 f1 of one motor, though two drive the axis."""
    found = outcome_of(tmp_path, "parabola", PARABOLA, fastest_fmus)
    (thrust,) = [value for value in found.values if value.name == "thrust"]
    stage = Stage5DOF()
    assert stage.start() == 0
    assert thrust.axis == "z"
    f1 = gap_functions(stage.block.magnetics.kinds[0].geometry, 0.025)[0]
    assert thrust.value == pytest.approx(stage.C2 * f1, rel=2e-3)
