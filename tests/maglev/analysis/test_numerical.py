"""Loops by differences: those of our laws against the equations, those of others against each other."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import error_line, maglev
from facts import raises
from scipy.linalg import block_diag
from written_controllers import controller

from maglev.analysis.numerical import NumericalLoop, linearise_numerically
from maglev.analysis.pair import AskedPair, make_pair
from maglev.files.errors import LinearModelError
from maglev.linear.loop import linearise_loop
from maglev.scenario.fmus_for_runs import fmus_named
from maglev.user.source import FmuFile

WITHIN = 2e-4   # of a margin: the loop that runs rests within some nanometres of where the equations do


@pytest.fixture(scope="module")
def pd_loop(fastest_fmus: Path, pd_class) -> NumericalLoop:
    """A class that runs in this process with our plant."""
    return linearise_numerically("Plant2DOF", pd_class(), {"v": 20e-3}, settle=2.0, fmus=fastest_fmus)


@pytest.mark.few(1)
@pytest.mark.parametrize(("stage", "at", "openings"), [
    ("2DOF", {"v": 18e-3, "h": 5e-3}, ("v", "h")),
    ("5DOF", {"y": 25e-3, "roll": 2e-3}, ("roll", "alpha1.gap_measured"))])
def test_our_regulators_by_differences_are_those_of_the_equations(
        stage: str, at: dict[str, float], openings: tuple[str, ...], fastest_fmus: Path) -> None:
    """The FMU is given as a file: nothing is known of it but what it answers."""
    found = linearise_numerically(f"Plant{stage}", fastest_fmus / f"Regulator{stage}.fmu", at, references=False,
                                  fmus=fastest_fmus)
    exact = linearise_loop(f"Plant{stage}", f"Regulator{stage}", at)
    assert found.why_not == ""
    assert max(each.error for each in found.derivatives) < 2e-6
    # Observers of 1 ms twice, integrators and internal models: five states of each axis.
    assert len(found.linear().controller.states) == 5 * len(exact.measured)
    for opening in openings:
        margins, wanted, errors = found.margins(opening), exact.margins(opening), found.errors(opening)
        for name in ("gain_down", "gain_up", "phase", "delay", "sensitivity_peak", "disk"):
            assert getattr(margins, name) == pytest.approx(getattr(wanted, name), rel=WITHIN), (opening, name)
            assert errors[name] < WITHIN * getattr(wanted, name)
    slow = exact.rates[exact.rates.real > -50.0]
    np.testing.assert_allclose(found.linear().rates[:len(slow)], slow, rtol=1e-3, atol=1e-3)


def test_plant_of_another_name_is_found_by_its_answers(fastest_fmus: Path, tmp_path: Path, pd_class,
                                                        pd_loop: NumericalLoop) -> None:
    """In this process ours is foreign by its name alone; its controller is a class."""
    theirs = tmp_path / "theirs.fmu"
    theirs.write_bytes((fastest_fmus / "Plant2DOF.fmu").read_bytes())
    found, known = linearise_numerically(theirs, pd_class(), {"v": 20e-3}, settle=2.0, fmus=fastest_fmus), pd_loop
    # Positions, velocities, and the two currents that the mover sees.
    assert len(found.linear().plant.states) == 6
    rates = known.linear().plant.rates
    np.testing.assert_allclose(found.linear().plant.rates, rates, rtol=1e-4, atol=1e-4)
    for axis in ("v", "h"):
        ours, others = vars(known.margins(axis)), vars(found.margins(axis))
        assert {key: others[key] for key in others if key != "at"} == pytest.approx(
            {key: ours[key] for key in ours if key != "at"}, rel=WITHIN)


def test_the_loop_as_python_control_has_it(pd_loop: NumericalLoop) -> None:
    """What its references do: a PD law without bias comes to rest where h is asked to be, and knows no other way."""
    pytest.importorskip("control")
    closed = pd_loop.linear().closed.to_control()
    assert closed.dt == 0.5e-3
    assert list(closed.input_labels) == ["v_reference", "h_reference"]
    gains = np.real(closed(1.0))   # at rest
    assert gains[1, 1] == pytest.approx(1.0, rel=1e-2)
    assert abs(gains[0, 1]) < 1e-3
    # The feed-forward of the gap leaves it short, as in a run.
    assert gains[0, 0] == pytest.approx(0.0, abs=2.0)


def test_command_line_of_an_fmu(fastest_fmus: Path, tmp_path: Path) -> None:
    file, given = tmp_path / "loop.json", fastest_fmus / "Regulator2DOF.fmu"
    done = maglev("linearise", "Plant2DOF", given, "--at", "v=20mm", "--fmus", fastest_fmus, "--open", "h", "--json",
                  file)
    assert done.exit_code == 0, done.output
    data = json.loads(file.read_text(encoding="utf-8"))
    known = linearise_loop("Plant2DOF", "Regulator2DOF", {"v": 20e-3}).margins("h")
    assert data["margins"]["h.measured"]["phase"] == pytest.approx(known.phase, rel=WITHIN)
    assert 0.0 < data["errors"]["h.measured"]["phase"] < 1e-5
    assert data["controller"]["inputs"] == ["v.measured", "h.measured", "v.reference", "v.reference_rate",
                                            "h.reference", "h.reference_rate"]


def test_fmus_of_fmi_3_are_taken_from_their_folder(fmi3_fmus: Path, tmp_path: Path) -> None:
    (tmp_path / "fmi3").symlink_to(fmi3_fmus)
    folder = fmus_named(("Plant3DOF", "Regulator3DOF"), None, tmp_path, fmi=3)
    pair = make_pair(AskedPair("Plant3DOF", "Regulator3DOF", {"y": 25e-3}, folder))
    assert pair.plant.source == FmuFile(tmp_path / "fmi3" / "Plant3DOF.fmu")
    for way in ((), ("--measure",)):
        done = maglev("linearise", *way, "Plant3DOF", fmi3_fmus / "Regulator3DOF.fmu", "--at", "y=25mm", "--fmi", "3",
                      "--kind", "python")
        assert "fmi = 3: expected 2, or 3 with kind = native" in error_line(done)


def test_a_file_runs_apart_and_a_rounding_is_named(fastest_fmus: Path, tmp_path: Path) -> None:
    """Without a derivative the command ends with 2, and the sentence that says where to look."""
    rounded = controller(tmp_path, ("        self.gap.update(", "        self.h_measured = round(self.h_measured, 4)\n"
                                    "        self.gap.update("))
    done = maglev("linearise", "Plant2DOF", rounded, "--at", "v=20mm", "--fmus", fastest_fmus, "--settle", "2 s",
                  "--set", "plant.h.bias=0")
    assert "h.measured has no derivative here: no response to 20 µ, one to 100 µ" in done.stdout
    assert "linearise --measure" in error_line(done)
    assert max(map(len, done.stdout.splitlines())) <= 80


def test_a_file_that_translates_has_its_matrices_by_hand(fastest_fmus: Path, tmp_path: Path) -> None:
    """Those of a PD with a filtered rate, written down here; a loop over nothing and the commutation included."""
    law = controller(tmp_path, ("        self.known = True\n", "        self.known = True\n"
                                "        for k in range(3):\n            self.known = k >= 0\n"))
    found = linearise_numerically("Plant2DOF", law, {"v": 20e-3}, fmus=fastest_fmus,
                                  plant_parameters={"h.bias": 0.0})
    assert found.exact
    model = found.linear().controller
    assert model.states == ("gap.last", "gap.rate", "travel.last", "travel.rate")
    step, follow = 0.5e-3, 0.5e-3 / 2e-3
    a = np.array([[0.0, 0.0], [-follow / step, 1.0 - follow]])
    b = np.array([1.0, follow / step])
    np.testing.assert_allclose(model.A, block_diag(a, a), rtol=1e-13)
    np.testing.assert_allclose(model.B[:, :2], block_diag(b[:, None], b[:, None]), rtol=1e-13)
    slope = np.array([60.0**2, 2.0 * 0.9 * 60.0])   # of a demand by a measurement and by its rate
    by_gap, by_travel = np.array([-(slope[0] + 1435.0), -slope[1]]) / 3.432, -slope / -6.68   # of i_d, i_q
    h = found.pair.positions["h"]
    angles = np.pi / 57.15e-3 * (h - 57.15e-3 / 2.0) - 2.0 * np.pi / 3.0 * np.array([0.0, 1.0, -1.0])
    turned = np.array([np.cos(angles), -np.sin(angles)]).T
    currents = found.linear().plant.equilibrium
    along = np.pi / 57.15e-3 * np.array([-np.sin(angles), -np.cos(angles)]).T @ [currents.i_d[0], currents.i_q[0]]
    rates = np.outer(turned[:, 0], by_gap[1] * a[1]), np.outer(turned[:, 1], by_travel[1] * a[1])
    assert np.hstack(rates) == pytest.approx(model.C, rel=1e-9)
    assert model.D[:, 0] == pytest.approx(turned[:, 0] * (by_gap[0] + by_gap[1] * b[1]), rel=1e-9)
    assert model.D[:, 1] == pytest.approx(turned[:, 1] * (by_travel[0] + by_travel[1] * b[1]) + along, rel=1e-6)
    assert set(found.errors("v.measured").values()) == {0.0}


@pytest.mark.parametrize(("change", "facts"), [
    ({"plant": "Plant2DOG"}, ["'Plant2DOG'", "'Plant2DOF'"]),
    ({"controller_parameters": {"bandwith": 50.0}}, ["PD", "'bandwith'", "'bandwidth'"]),
    ({"controller_parameters": {"bandwidth": 5.0}}, ["at rest"]),
    ({"sample_time": "2 s"}, ["PD", "sample time", "2.0 s", "1 s"])])
def test_refusals(change: dict, facts: list[str], fastest_fmus: Path, pd_class) -> None:
    given = {"plant": "Plant2DOF", "controller": pd_class(), "at": {"v": 20e-3}, "settle": 0.5, **change}
    with raises(LinearModelError, *facts):
        linearise_numerically(**given, fmus=fastest_fmus)
