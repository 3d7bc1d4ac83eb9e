"""Regions from Python and from the command line: contents, runs, pictures, and what is refused."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import error_line, maglev
from facts import raises

import maglev as tool
from maglev.analysis import certificate
from maglev.analysis.axis_loop import axis_loop
from maglev.analysis.region import StepRuns, region
from maglev.analysis.region_result import Region
from maglev.files.errors import FmuError, LinearModelError, MaglevError, StabilityError

pytestmark = pytest.mark.usefixtures("slow")

PAGE = Path(__file__).parents[3] / "docs" / "results_stability.md"

SMOOTH = {f"plant.{axis}.{effect}": 0.0 for axis in "yxz" for effect in ("bias", "friction.coulomb",
                                                                        "friction.viscous")}


@pytest.fixture(scope="module")
def found() -> Region:
    return region("3dof", "x", "25 mm", synthesise=True, step="20 mm", run=False)


@pytest.mark.thorough
def test_a_region_has_the_requested_candidates(found: Region) -> None:
    assert [each.name for each in found.candidates] == ["as set", "without", "synthesised"]
    assert found["as set"].gains == pytest.approx([1.1e-4] * 3)
    for each in found.candidates:
        assert each.certificate.step < each.simulated
        assert each.response.step == 0.02
    assert found["synthesised"].response.overshoot < found["as set"].response.overshoot
    assert found["without"].response.overshoot > found["as set"].response.overshoot
    assert tool.region is region
    with raises(StabilityError, "'best'", "as set, without, synthesised"):
        found["best"]


@pytest.mark.thorough
def test_pictures_text_and_data(found: Region, tmp_path: Path) -> None:
    found.plot().savefig(tmp_path / "region.png")
    assert (tmp_path / "region.png").read_bytes().startswith(b"\x89PNG")
    lines = str(found).splitlines()
    assert max(map(len, lines)) <= 80
    assert [re.split(r"  +", line)[:3] for line in lines if line.startswith(("anti", "certified (", "held ("))] == [
        ["anti-windup", "as set", "without"], ["certified (mm)", "17.3", "14.4"], ["held (mm)", "not run", "not run"]]
    data = json.loads(json.dumps(found.as_data(), allow_nan=False))
    candidate = data["candidates"]["as set"]
    start = candidate["certified_step"] * found.loop.at_step
    assert start @ np.array(candidate["P"]) @ start == pytest.approx(1.0)


@pytest.mark.thorough
def test_section_and_shadow_of_the_ellipsoid(found: Region) -> None:
    """No state of the section is outside the shadow, and steps end where the section does."""
    certified = found["as set"].certificate
    plane = np.column_stack([found.loop.at_step, found.loop.in_motion])
    assert certified.section(plane)[0, 0] ** -0.5 == pytest.approx(certified.step)
    assert np.linalg.eigvalsh(certified.section(plane) - certified.shadow()).min() > 0.0


@pytest.mark.parametrize(("arguments", "kind", "facts"), [
    ({"stage": "4dof"}, StabilityError, ["stage", "'4dof'", "2dof", "3dof"]),
    ({"axis": "v"}, StabilityError, ["3dof", "axis", "'v'", "y, x, z"]),
    ({"gap": "31 mm"}, LinearModelError, ["Plant3DOF", "y", "31 mm", "alpha", "-4.65 A", "0.159 A"]),
    ({"gap": "19 mm", "set": {"controller.current_limit": 1.0}}, LinearModelError, ["current_limit", "1 A"]),
    ({"controller": "PID3DOF"}, StabilityError, ["3dof", "controller", "'PID3DOF'", "output regulator"]),
    ({"set": {"controller.current_limit": 0.0}}, StabilityError, ["Regulator3DOF", "current_limit", "0 A"]),
    ({"set": {"controller.x.k1": 463.0}}, StabilityError, ["unstable"]),
    ({"set": {"controller.x.k9": 1.0}}, LinearModelError, ["Regulator3DOF", "'x.k9'", "'x.k5'"]),
    ({"set": {"x.k1": 1.0}}, StabilityError, ["set", "x.k1", "1.0", "plant", "controller"]),
    ({"decay": -1.0}, StabilityError, ["decay", "-1.0 1/s", "0 1/s"]),
    ({"decay": 2.5}, StabilityError, ["decay", "2.5 1/s", "synthesise"]),
    ({"decay": 3000.0, "synthesise": True}, StabilityError, ["x", "Plant3DOF", "Regulator3DOF", "25 mm"]),
    ({"step": "0 mm"}, StabilityError, ["step", "0 m"]), ({"step": "3 s"}, StabilityError, ["step", "'3 s'", "m"]),
    ({"fmus": "nowhere"}, FmuError, ["nowhere/Regulator3DOF.fmu"])])
def test_refusals(arguments: dict[str, Any], kind: type[MaglevError], facts: list[str]) -> None:
    with raises(kind, *facts):
        region(**{"stage": "3dof", "axis": "x", "gap": "25 mm", **arguments})


def test_without_cvxpy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("maglev.files.errors.find_spec", lambda _: None)
    line = error_line(maglev("region", "3dof", "x", "--gap", "25mm"))
    assert line == ("maglev: a region needs cvxpy; install it with the Python that runs maglev: python -m pip install "
                    "'maglev-fmus[region]'")


def test_command_line_refuses() -> None:
    assert error_line(maglev("region", "3dof", "x", "--gap", "31mm")).startswith("maglev: Plant3DOF at y = 31 mm: ")
    assert "expected a name, = and a value" in error_line(maglev("region", "3dof", "x", "--gap", "25mm", "--set", "a"))


def test_the_command_gives_text_picture_and_data(fastest_fmus: Path, tmp_path: Path) -> None:
    """Of the axis that takes a second; others weekly."""
    done = maglev("region", "2dof", "v", "--gap", "20mm", "--json", tmp_path / "v.json", "--plot", "--out", tmp_path,
                  "--fmus", fastest_fmus)
    assert done.exit_code == 0, done.output
    data = json.loads((tmp_path / "v.json").read_text())
    candidate, = data["candidates"].values()
    start = candidate["certified_step"] * axis_loop("2dof", "v", "20 mm").at_step
    assert start @ np.array(candidate["P"]) @ start == pytest.approx(1.0)
    assert candidate["certified_step"] <= candidate["simulated_step"]
    lines = done.stdout.splitlines()
    assert max(map(len, lines[:-2])) <= 80
    cells = dict(re.split(r"  +", line) for line in lines if "  " in line)
    assert (cells["anti-windup"], cells["Ec1"], cells["Ec3"]) == ("without", "0", "0")
    assert float(cells["certified (mm)"]) == pytest.approx(1e3 * candidate["certified_step"], abs=0.05)
    to_the_stop = 28e-3 - 20e-3 - 0.5e-3
    assert (candidate["run"]["held"], candidate["run"]["largest_step"]) == (True, pytest.approx(to_the_stop))
    assert cells["held (mm)"] == "≥ 7.5"
    assert (tmp_path / "region-2dof-v.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.thorough
def test_runs_are_as_simulated_while_the_gap_is_locked(fastest_fmus: Path) -> None:
    """A step of 20 mm, into the limit, without what the linear model leaves out except for the encoder."""
    simulated = region("3dof", "x", "25 mm", step="20 mm", set=SMOOTH, run=False)
    settings = {name.removeprefix("plant."): value for name, value in SMOOTH.items()}
    for each in simulated.candidates:
        gains = {f"x.ec{k}": float(gain) for k, gain in enumerate(each.gains, 1)}
        with StepRuns("3dof", "x", "25 mm", "Regulator3DOF", settings, {}, fastest_fmus, locked=True) as runs:
            response, held = runs.respond(0.02, gains)
        assert held
        assert np.abs(response.position[:25000] - each.response.position[:25000]).max() < 20e-6
        assert response.overshoot == pytest.approx(each.response.overshoot, abs=1e-3)


@pytest.mark.thorough
def test_at_25_mm_the_stage_holds_more_than_is_certified(fastest_fmus: Path) -> None:
    simulated = region("3dof", "x", "25 mm", run=True, fmus=fastest_fmus)
    for each in simulated.candidates:
        assert each.run is not None and each.run.held and each.run.largest_locked is not None
        assert each.certificate.step < each.run.largest < each.run.largest_locked


@pytest.mark.thorough
def test_simulated_steps_are_next_to_certified_steps(fastest_fmus: Path, tmp_path: Path,
                                                       monkeypatch: pytest.MonkeyPatch) -> None:
    """At 29 mm, where the stage falls first, it holds less than is certified of its linear loop."""
    shown = []

    def kept(*arguments: Any, **options: Any) -> Region:
        shown.append(region(*arguments, **options))
        return shown[-1]

    monkeypatch.setattr("maglev.analysis.region.region", kept)
    done = maglev("region", "3dof", "x", "--gap", "29mm", "--set", "controller.x.ec1=1.2e-4", "--json",
                  tmp_path / "x.json", "--plot", "--out", tmp_path, "--fmus", fastest_fmus)
    assert done.exit_code == 0, done.output
    assert "x of Plant3DOF with Regulator3DOF at y = 29 mm: 0.2 ms" in done.stdout
    assert "\ngap locked (mm)  " in done.stdout
    assert (tmp_path / "region-3dof-x.png").is_file()
    names, *cells = (next(re.split(r"  +", line)[:2] for line in done.stdout.splitlines() if line.startswith(begin))
                     for begin in ("anti-windup", "certified (mm)", "held (mm)"))
    assert names[1] == "as set"
    certified, held = (float(cell) for _, cell in cells)
    assert held < certified
    found = json.loads((tmp_path / "x.json").read_text())["candidates"]["as set"]
    assert found["Ec"] == [1.2e-4, 1.1e-4, 1.1e-4]
    assert (found["certified_step"], found["run"]["largest_step"]) == pytest.approx((1e-3 * certified, 1e-3 * held),
                                                                                     abs=0.05e-3)
    run = shown[0]["as set"].run
    assert run is not None and run.largest_locked is not None and run.largest < run.largest_locked
    assert shown[0]["as set"].title == f"as set: {certified} mm certified, {held} mm held"


def test_steps_end_where_the_stops_do(fastest_fmus: Path) -> None:
    """At 20 mm the gap can step by 1 mm from a start off the lower stop: no more is run, whatever is certified."""
    found = region("3dof", "y", "20 mm", fmus=fastest_fmus)["as set"]
    assert found.run is not None
    assert found.run.largest == found.run.room == pytest.approx(1e-3)
    assert found.largest == ("4.4", "≥ 1.0")
    assert found.response.step == found.run.room


@pytest.mark.thorough
@pytest.mark.parametrize(("axis", "words"), [("y", r"For y it is (\S+) and (\S+) mm"),
                                             ("roll", r"for roll and pitch (\S+) and (\S+) mrad")])
def test_certified_steps_of_a_platform_that_tilts_are_held(fastest_fmus: Path, axis: str, words: str) -> None:
    """Of a tilt to level in both directions, as the page has it; a tenth more than the largest held is lost."""
    found = re.search(words, " ".join(PAGE.read_text(encoding="utf-8").split()))
    assert found, words
    certified, held = (1e-3 * float(step) for step in found.groups())
    loop = axis_loop("5dof", axis, "25 mm")
    assert certificate.certify(loop, loop.gains).step == pytest.approx(certified, rel=0.02)
    with StepRuns("5dof", axis, "25 mm", "Regulator5DOF", {}, {}, fastest_fmus) as runs:
        assert all(runs.respond(sign * certified, {})[1] for sign in (-1.0, 1.0))
        assert not all(runs.respond(sign * 1.1 * held, {})[1] for sign in (-1.0, 1.0))
        with raises(StabilityError, "Plant5DOF", axis, "40 mm" if axis == "y" else "40 mrad"):
            runs.respond(0.04, {})


def page_rows(begin: str) -> list[list[str]]:
    """Cells of the rows of the page that begin so."""
    text = PAGE.read_text(encoding="utf-8")
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()
            if re.match(begin, line)]


@pytest.mark.thorough
def test_the_page_has_the_simulated_steps(fastest_fmus: Path) -> None:
    """Steps somewhat smaller are held in both directions; larger ones, where there is room, are lost in one."""
    rows = page_rows(r"\| \d\d mm \|")
    assert len(rows) == 5
    for gap, *steps in rows:
        for axis, (certified, simulated) in zip("xzy", (steps[0:2], steps[3:5], steps[6:8]), strict=True):
            loop = axis_loop("3dof", axis, gap)
            assert certificate.certify(loop, loop.gains).step == pytest.approx(1e-3 * float(certified), abs=0.0501e-3)
            step = 1e-3 * float(simulated.removeprefix("≥ "))
            with StepRuns("3dof", axis, gap, "Regulator3DOF", {}, {}, fastest_fmus) as runs:
                assert all(runs.respond(sign * 0.95 * step, {})[1] for sign in (-1.0, 1.0)), (gap, axis)
                if not simulated.startswith("≥"):
                    assert not all(runs.respond(sign * 1.1 * step, {})[1] for sign in (-1.0, 1.0)), (gap, axis)


@pytest.mark.thorough
def test_the_page_has_the_certified_steps() -> None:
    rows = [row for row in page_rows(r"\| [xyz] \|") if row[1] in ("(5.15)", "none", "synthesised")]
    assert len(rows) == 9
    for axis, name, printed, certified, *_ in rows:
        loop = axis_loop("3dof", axis, "25 mm")
        gains = np.array([float(gain) for gain in printed.replace("−", "-").split(",")]) * np.ones(3)
        if name == "(5.15)":
            assert gains == pytest.approx(loop.gains)
        assert certificate.certify(loop, gains).step == pytest.approx(1e-3 * float(certified), rel=0.02)
