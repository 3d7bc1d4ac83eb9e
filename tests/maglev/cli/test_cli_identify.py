"""`maglev identify` as a user types it, and its constants on the way back."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from command_line import error_line, maglev
from facts import raises
from identification_data import record

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.errors import IdentificationError, ScenarioError
from maglev.identification.model_file import model_settings


@pytest.fixture(scope="module")
def recording(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """10 s of the real 2-DOF stage at 1 kHz."""
    r = record("2dof", 10.0, 1e-3, ideal=False).recording
    path = tmp_path_factory.mktemp("data") / "mine.csv"
    np.savetxt(path, np.column_stack([r.time, r.positions, r.i_d, r.i_q]), delimiter=",",
               header="time,v,h,i_d,i_q", comments="", fmt="%.9g")
    return path


@pytest.mark.usefixtures("slow")
def test_identify(recording: Path, tmp_path: Path) -> None:
    result = maglev("identify", recording, "--matched", "--epsilon", "10 ms", "--guess", "C1=9", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert "warning: C4: cannot be identified" in result.output
    assert "standard error" in result.output
    table = tomllib.loads((tmp_path / "mine.identified.toml").read_text(encoding="utf-8"))
    assert table["stage"] == "2dof"
    assert table["plant"] == table["controller"]
    # What is not identified is not taken for a constant.
    assert set(table["plant"]) == {"C1", "C2", "C3"}
    assert "is not identified: the FMU keeps its own" in (tmp_path / "mine.identified.toml").read_text(encoding="utf-8")
    assert table["plant"]["C2"] == pytest.approx(791.0, rel=0.05)
    convergence = np.genfromtxt(tmp_path / "mine.convergence.csv", delimiter=",", names=True)
    assert convergence["C1"][0] == 9.0
    assert convergence["C2"][-1] == table["plant"]["C2"]
    assert convergence.shape[0] < 3000
    assert (tmp_path / "mine.convergence.png").is_file() or (tmp_path / "mine.convergence.html").is_file()
    expected = {f"{participant}.C{k}": table[participant][f'C{k}'] for participant in ("plant", "controller")
                for k in (1, 2, 3)}
    assert model_settings(tmp_path / "mine.identified.toml", PACKAGED_STAGES["2dof"]) == expected
    # A file that ends inside a number is TOML, too.
    text = (tmp_path / "mine.identified.toml").read_text(encoding="utf-8")
    (tmp_path / "mine.identified.toml").write_text(text[:text.rindex("\nC3 = ") + 8], encoding="utf-8")
    with raises(IdentificationError, "'# end of the constants'"):
        model_settings(tmp_path / "mine.identified.toml", PACKAGED_STAGES["2dof"])


@pytest.mark.parametrize(("arguments", "message"), [
    (["--method", "ful"], "method ful: expected one of reduced, full, fsdi; nearest is 'full'"),
    (["--epsilon", "1 mm"], "epsilon = 1 mm: '1 mm' is in mm, expected a quantity in s"),
    (["--epsilon", "0"], "epsilon = 0.0: expected a time above 0 s"),
    (["--gamma", "1"], "gamma = 1.0: expected more than 1, such as 1.1"),
    (["--guess", "D1=3"], "guess: D1 = 3: expected a value, such as C1=10, of one of C1, C2, C3, C4"),
    (["--guess", "C1"], "--guess C1: expected a constant and a value, such as C1=10"),
    (["--guess", "C1=3 A"], "guess: C1 = 3 A: '3 A' is in A, expected a quantity in 1"),
    (["--stage", "3dof"], "no column y, expected y or plant.y")])
def test_refusals(recording: Path, tmp_path: Path, arguments: list[str], message: str) -> None:
    assert message in error_line(maglev("identify", recording, "--out", tmp_path, *arguments))


def test_missing_recording(tmp_path: Path) -> None:
    assert "cannot be read" in error_line(maglev("identify", tmp_path / "no.csv", "--out", tmp_path))


def model(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "model.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(("text", "settings"), [
    ("[plant]\nC1 = 14.5\n", {"plant.C1": 14.5}),
    ("[controller]\nC4 = 1\nC2 = 790\n", {"controller.C2": 790.0, "controller.C4": 1.0}),
    ("C1 = 3.0\n", {"plant.C1": 3.0, "controller.C1": 3.0}),
    ('stage = "2dof"\nC1 = 3.0\n[plant]\nC1 = 4.0\n', {"plant.C1": 4.0, "controller.C1": 3.0})])
def test_model_settings(tmp_path: Path, text: str, settings: dict[str, float]) -> None:
    assert model_settings(model(tmp_path, text)) == settings


@pytest.mark.parametrize(("text", "facts"), [
    ("", ["constants", "C1", "[plant]", "[controller]"]), ("C1 = \n", ["TOML", "(at line 1, column 6)"]),
    ("[plant]\nC9 = 1.0\n", ["plant.C9", "'C1', 'C2', 'C3'"]), ("[plnt]\nC1 = 1.0\n", ["plnt", "'plant'"]),
    ("plant = 3\n", ["plant", "3", "[plant]"]), ("[plant]\nC1 = 'x'\n", ["plant.C1", "'x'", "above 0"]),
    ("C1 = -1.0\n", ["C1", "-1.0", "above 0"]), ("C1 = true\n", ["C1", "True", "above 0"]),
    ("C1 = nan\n", ["C1", "nan", "above 0"]),
    ('stage = "6dof"\nC1 = 1.0\n', ["stage", "'6dof'", "2dof, 3dof, 5dof"]),
    ('stage = "2dof"\nC5 = 1.0\n', ["C5", "'C1', 'C2'"]), ('stage = "2dof"\nC1 = 1.0\n', ["stage", "'2dof'", "3dof"])])
def test_bad_models(tmp_path: Path, text: str, facts: list[str]) -> None:
    path = model(tmp_path, text)
    with raises(ScenarioError if "TOML" in facts else IdentificationError, path, *facts):
        model_settings(path, PACKAGED_STAGES["3dof"] if "3dof" in facts else None)


def test_missing_model(tmp_path: Path) -> None:
    model(tmp_path, "C1 = 1.0\n")
    with raises(ScenarioError, "'model.toml'"):
        model_settings(tmp_path / "modle.toml")
