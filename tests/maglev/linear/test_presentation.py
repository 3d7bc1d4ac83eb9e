"""Linear models as text, as JSON, as python-control has them, as pictures, and at the command line."""

import doctest
import json
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from command_line import maglev
from facts import raises

from maglev.files.errors import LinearModelError
from maglev.linear.linearise import linearise


def test_text_has_names_units_equilibrium_and_poles() -> None:
    text = str(linearise("Plant3DOF", {"y": "25 mm"}, amplifier=False))
    assert text.startswith("Plant3DOF, continuous, about y = 25 mm, x = 0 mm, z = 0 mm; alpha.i_d = -1.192 A, alpha.")
    assert "inputs   1 alpha.i_d_cmd (A), 2 alpha.i_q_cmd (A), 3 beta.i_d_cmd (A), 4 beta.i_q_cmd (A)" in text
    rows = [line.split() for line in text.splitlines() if line.startswith("y.velocity")]
    assert rows == [["y.velocity", "1512.56", "·", "·", "-0.289855", "·", "·"],
                    ["y.velocity", "1.26611", "-0.00201667", "1.26611", "-0.00150441"]]
    assert "D = 0, 3 × 4" in text
    assert "\n38.747 " in text


@pytest.mark.usefixtures("slow")
def test_python_control_has_the_same_model() -> None:
    import control  # which takes a second

    plant = linearise("Plant3DOF", {"y": "25 mm"})
    system = plant.to_control()
    assert system.isctime(strict=True)
    assert system.state_labels[0] == "y_position"
    frequencies = np.array([0.1, 30.0, 2000.0])
    ours = plant.frequency_response(frequencies)
    theirs = np.array([system(1j * w) for w in frequencies])
    assert ours == pytest.approx(theirs, rel=1e-9, abs=1e-15)
    # Exact hold of the inputs, by python-control as by us.
    sampled = control.sample_system(system, 1e-3, method="zoh")
    np.testing.assert_allclose(sampled.A, plant.discretise(1e-3).A, rtol=1e-9, atol=1e-12)
    controller = linearise("Regulator3DOF", plant.equilibrium).to_control()
    assert controller.dt == 0.2e-3
    assert controller.input_labels[2] == "y_measured"


def test_without_python_control(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "control", None)
    with raises(LinearModelError, "'maglev-fmus[design]'"):
        linearise("Plant2DOF", {"v": "20 mm"}).to_control()


def test_sampled_twice_and_names_that_are_not_there() -> None:
    plant = linearise("Plant2DOF", {"v": "20 mm"}, hold=0.5e-3, forces=True)
    with raises(LinearModelError, "Plant2DOF", "0.0005 s"):
        plant.discretise(0.5e-3)
    with raises(LinearModelError, "'v.forc'", "'v.force'"):
        plant.select(["v.forc"], ["v.position"])
    small = plant.select(["v.force"], ["h.position"])
    assert small.B[:, 0].tolist() == plant.B[:, 2].tolist()
    assert small.C.tolist() == plant.C[1:].tolist()


@pytest.mark.parametrize("module", ["linearise", "loop"])
def test_examples_of_the_docstrings(module: str) -> None:
    result = doctest.testmod(import_module(f"maglev.linear.{module}"))
    assert result.attempted > 1
    assert result.failed == 0


def test_command_line_of_one_model(tmp_path: Path) -> None:
    file = tmp_path / "deep" / "plant.json"
    result = maglev("linearise", "Plant3DOF", "--at", "y=25mm", "--at", "x=-4 mm", "--currents", "phases", "--hold",
                    "0.2ms", "--no-amplifier", "--forces", "--set", "plant.y.mass=7.2kg", "--json", file)
    assert result.exit_code == 0, result.output
    model = linearise("Plant3DOF", {"y": 0.025, "x": -0.004}, currents="phases", hold=0.2e-3, amplifier=False,
                      forces=True, parameters={"y.mass": 7.2})
    assert result.output.startswith(str(model))
    data = json.loads(file.read_text(encoding="utf-8"))
    assert data["A"] == model.A.tolist()
    assert data["inputs"][-1] == "z.force"
    assert data["equilibrium"]["positions"] == {"y": 0.025, "x": -0.004, "z": 0.0}
    assert data["sample_time"] == 0.2e-3


@pytest.mark.usefixtures("slow")
def test_command_line_of_a_loop(tmp_path: Path) -> None:
    file = tmp_path / "loop.json"
    result = maglev("linearise", "Plant2DOF", "Regulator2DOF", "--at", "v=20mm", "--open", "v", "--open", "motor.i_q",
                    "--set", "controller.v.k1=-1700", "--plot", "--json", file, "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert "opened at" in result.output
    data = json.loads(file.read_text(encoding="utf-8"))
    assert list(data["margins"]) == ["v.measured", "motor.i_q_cmd"]
    assert data["margins"]["v.measured"]["phase"] == pytest.approx(0.75, abs=0.1)
    assert [Path(path).stat().st_size > 10_000 for path in data["pictures"]] == [True, True]
    assert Path(data["pictures"][0]) == tmp_path / "Plant2DOF-Regulator2DOF.bode.png"
