"""Controllers that others write run the 2-DOF stage: other names, other units, other steps, fewer ports."""

import csv
import re
from pathlib import Path

import pytest
from command_line import error_line, maglev
from fmpy_validation import validate_fmu

MAP = Path(__file__).parents[2] / "examples" / "pd_controller_c" / "ports.toml"


def column(path: Path, name: str) -> list[float]:
    """Column of a CSV."""
    with path.open() as file:
        return [float(row[name]) for row in csv.DictReader(file)]


def levitates(csv_file: Path) -> None:
    """It starts at 20 mm, follows the step to 21 mm, and stays within what friction and bias leave of it."""
    gap = column(csv_file, "plant.v.position")
    assert gap[0] == pytest.approx(20e-3, abs=1e-6)
    assert gap[300] == pytest.approx(20e-3, abs=0.3e-3)
    assert gap[-1] == pytest.approx(21e-3, abs=0.3e-3)
    assert min(gap) > 19e-3
    assert max(gap) < 22e-3


@pytest.fixture
def mapped(tmp_path: Path):
    """Function that writes the map of the C controller with changes."""
    def write(*changes: tuple[str, str]) -> Path:
        text = MAP.read_text()
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "ports.toml"
        path.write_text(text)
        return path
    return write


def test_c_controller_is_valid(c_controller: Path) -> None:
    assert validate_fmu(str(c_controller)) == []


def test_c_controller_levitates_the_stage(fmus: Path, step: Path, c_controller: Path, tmp_path: Path) -> None:
    result = maglev("run", step, "--fmus", fmus, "--out", tmp_path, "--controller", c_controller, "--map", MAP)
    assert result.exit_code == 0, result.output
    levitates(tmp_path / "step.csv")
    # In SI under our names: the reference that the FMU gets in mm, and the currents, which sum to zero.
    assert column(tmp_path / "step.csv", "controller.v.reference")[-1] == 0.021
    phases = [column(tmp_path / "step.csv", f"controller.motor.i_{phase}_cmd") for phase in "abc"]
    assert max(abs(sum(currents)) for currents in zip(*phases, strict=True)) < 1e-12


def test_missing_ports_are_named_once_and_left_out(fastest_fmus: Path, step: Path, c_controller: Path,
                                                   tmp_path: Path) -> None:
    result = maglev("report", step, "--fmus", fastest_fmus, "--out", tmp_path, "--controller", c_controller,
                    "--map", MAP)
    assert result.exit_code == 0, result.output
    assert result.stderr.count("controller (pd_controller.fmu) has no tripped, motor.i_d_cmd, motor.i_q_cmd") == 1
    text = (tmp_path / "step.txt").read_text()
    assert re.search(r"\n +peak +mean\nmotor +current +current\n", text) and not re.search(r"\bcommand\b", text)
    assert "Commands are small (here): controller (pd_controller.fmu) has no motor.i_d_cmd" in " ".join(text.split())
    claims = (tmp_path / "claims.md").read_text()
    assert "| It holds | here | kept the stage in the air | kept the stage in the air | met |" in claims
    assert "**not testable**: controller (pd_controller.fmu) has no motor.i_d_cmd" in claims
    assert (tmp_path / "report.html").is_file()


def test_python_controller_needs_no_map(fastest_fmus: Path, step: Path, python_controller: Path, c_controller: Path,
                                        tmp_path: Path) -> None:
    result = maglev("run", step, "--fmus", fastest_fmus, "--out", tmp_path / "python", "--controller",
                    python_controller)
    assert result.exit_code == 0, result.output
    levitates(tmp_path / "python" / "step.csv")
    maglev("run", step, "--fmus", fastest_fmus, "--out", tmp_path / "c", "--controller", c_controller, "--map", MAP)
    gaps = [column(tmp_path / name / "step.csv", "plant.v.position") for name in ("python", "c")]
    # The same law: they differ by rounding, until that is a step of the encoder.
    assert max(abs(a - b) for a, b in zip(*gaps, strict=True)) < 0.1e-3


@pytest.mark.parametrize("own", ["1 ms", "0.1 ms", "0.5 ms"])
def test_other_steps(fastest_fmus: Path, step: Path, c_controller: Path, tmp_path: Path, mapped, own: str) -> None:
    ports = mapped(("[controller]", f'[controller]\nstep = "{own}"'))
    result = maglev("run", step, "--fmus", fastest_fmus, "--out", tmp_path, "--controller", c_controller, "--map",
                    ports)
    assert result.exit_code == 0, result.output
    levitates(tmp_path / "step.csv")


@pytest.mark.parametrize(("changes", "message"), [
    ([("[controller]", '[controller]\nstep = "0.3 ms"')], "expected a multiple of the communication step, 0.0005 s"),
    ([("[controller]", '[controller]\nstep = "0.3 s"')], "expected a whole fraction of the stop time, 1 s"),
    ([("[controller]", '[controller]\nstep = "1 mm"')], "controller.step = '1 mm'"),
    ([("[controller]", "[controler]")], "unknown table 'controler', nearest is 'controller'"),
    ([("[controller]", "[plant]")], "[plant]: needs plant"),
    ([('"v.measured"', '"v.mesured"')], "unknown port, nearest is 'v.measured'"),
    ([('"gap"', '"gapp"')], "the FMU has no 'gapp', nearest is 'gap'"),
    ([('"travel"', '"gap"')], "'gap' is 'v.measured' already"),
    ([('"gap", unit = "mm"', '"gap", unit = "mmm"')], "unknown unit 'mmm'; nearest is 'mm'"),
    ([('"gap", unit = "mm"', '"gap", unit = "A"')], "expected a unit that converts to m"),
    ([('port = "gap"', 'prot = "gap"')], ".prot = 'gap': unknown key, expected port or unit"),
    ([('= "current_u"', "= 7")], "= 7: expected the name of a port"),
    ([("[controller]", "[controller")], "TOML syntax"),
    ([('"v.measured" = { port = "gap", unit = "mm" }\n', ""), ('"motor.i_c_cmd" = "current_w"\n', "")],
     "missing ports: input v.measured (there is 'gap'), output motor.i_c_cmd (there is 'current_w')")])
def test_wrong_maps(fastest_fmus: Path, step: Path, c_controller: Path, tmp_path: Path, mapped,
                    changes: list[tuple[str, str]], message: str) -> None:
    result = maglev("run", step, "--fmus", fastest_fmus, "--out", tmp_path, "--controller", c_controller, "--map",
                    mapped(*changes))
    assert result.exit_code == 2, result.output
    *notes, error = result.stderr.strip().splitlines()
    assert message in error
    assert all("(pd_controller.fmu) has no" in line or "starts with" in line for line in notes)


def test_map_without_an_fmu(fastest_fmus: Path, step: Path) -> None:
    line = error_line(maglev("run", step, "--fmus", fastest_fmus, "--map", MAP))
    assert "[controller]: needs controller" in line


@pytest.mark.thorough
def test_check_says_where_it_leaves_the_baseline(fastest_fmus: Path, step: Path, c_controller: Path,
                                                 python_controller: Path, tmp_path: Path) -> None:
    common: list[str | Path] = ["check", step, "--fmus", fastest_fmus, "--baselines", tmp_path / "baselines"]
    assert maglev(*common, "--update").exit_code == 0
    given: list[list[str | Path]] = [["--controller", c_controller, "--map", MAP], ["--controller", python_controller]]
    for arguments in given:
        result = maglev(*common, *arguments)
        assert result.exit_code == 1, result.output
        assert "step: deviates first at t = 0.05 s: plant.v.position expected 0.0" in result.output
    missing = maglev(*common, "--controller", c_controller)
    assert missing.exit_code == 2
    assert "step: error: controller (pd_controller.fmu): missing ports: input v.measured" in missing.output
    # What the FMU has no signal for is not compared, and that is said.
    step.write_text(step.read_text().replace("1 nm", "100 mm"))
    assert maglev(*common, "--update").exit_code == 0
    passed = maglev(*common, "--controller", c_controller, "--map", MAP)
    assert passed.exit_code == 0, passed.output
    assert "not compared, for the FMU has no such signals: controller.motor.i_d_cmd" in passed.output
