"""A tuning file to begin with, for a regulator and for a controller in Python: it reads, and names what there is."""

from pathlib import Path

import pytest
from facts import raises

import maglev
from maglev.files.errors import ScenarioError
from maglev.many.tuning_plan import load_tuning


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("scenario", ["2dof-setpoints", "3dof-setpoints", "5dof-setpoints"])
def test_poles_of_a_regulator(scenario: str) -> None:
    tuning, _ = load_tuning(maglev.new_tuning("quicker", scenario))
    assert (tuning.name, tuning.scenario, tuning.controller) == ("quicker", scenario, None)
    assert tuning.poles[0].of and not tuning.search


def test_parameters_of_a_controller_in_python() -> None:
    maglev.new_controller("lqi.py", "3dof")
    tuning, _ = load_tuning(maglev.new_tuning("quicker.toml", "3dof-setpoints", "lqi.py"))
    assert tuning.controller == "lqi.py"
    assert not tuning.poles and len(tuning.search) > 1
    assert all(name.startswith("controller.") for searched in tuning.search for name in searched.set)
    assert "controller.sample_time" not in [name for searched in tuning.search for name in searched.set]
    assert all(2.0 * searched.low.value > 0.0 for searched in tuning.search)


@pytest.mark.parametrize(("scenario", "facts"), [
    ("2dof-pid-large", ["controller", "PID2DOF", "output regulator", "FILE"]), ("nope", ["'nope'"])])
def test_refuses_a_controller_without_poles(scenario: str, facts: list[str]) -> None:
    with raises(ScenarioError, *facts):
        maglev.new_tuning("quicker", scenario)
    assert not Path("quicker.toml").exists()


@pytest.mark.usefixtures("slow")
def test_tunes_a_controller_next_to_the_file() -> None:
    """Twelve runs of half a second: the values found are within those searched, and the controller's."""
    maglev.new_controller("pd.py", "2dof")
    text = maglev.new_tuning("quicker", "2dof-smooth-nonlinear", "pd.py").read_text("utf-8")
    text = text.replace("population = 8 ", "population = 5 ").replace("generations = 6", "generations = 1")
    text = text[:text.index("# The plants")].replace('"peak current" = 1.1', '"peak current" = 5')
    Path("quicker.toml").write_text(text, "utf-8")
    tuned = maglev.tune("quicker.toml", jobs=1)
    assert tuned.parameters.keys() == {name for searched in tuned.planned.tuning.search for name in searched.set}
