"""Results say what ran: version, command, FMUs, and every value that is not the plan's."""

import json
from importlib.metadata import version
from pathlib import Path

import pytest
from command_line import maglev
from facts import warns

from maglev.api.running import run_all
from maglev.cosim.fmi_versions import OWN_TOOL
from maglev.runs.preparation import prepare
from maglev.runs.replacement import Replacement
from maglev.scenario.loading import load_plan
from maglev.scenario.settings import start_values
from maglev.user.source import FmuFile

RUN = "3dof-pid-small-nonlinear"


def changes(fmus: Path, *settings: str) -> tuple[str, ...]:
    return prepare(load_plan(RUN), fmus, {}, start_values(settings)).changes


def test_the_thesis_run(fmus: Path) -> None:
    found = prepare(load_plan(RUN), fmus, {}, {}).provenance()
    assert not found.modified
    assert found.version == version("maglev-fmus")
    assert [(fmu.name, fmu.kind, fmu.put_in) for fmu in found.fmus] == [
        ("controller", "Python", False), ("plant", "Python", False)]
    assert all(fmu.guid.startswith("{") and fmu.tool.startswith(OWN_TOOL) for fmu in found.fmus)


def test_only_what_differs_is_a_change(fmus: Path) -> None:
    """A value that the plan, or else the FMU, has anyway changes nothing."""
    default = prepare(load_plan(RUN), fmus, {}, {}).parameters()["plant.y.mass"]
    assert changes(fmus, f"plant.y.mass={default!r}") == ()
    assert changes(fmus, "reference.y.amplitude=1") == ()
    assert changes(fmus, "reference.y.amplitude=0.5") == ("reference.y.amplitude = 0.5",)
    assert changes(fmus, "plant.y.mass=8") == (f"plant.y.mass = 8 kg instead of {default} kg",)
    assert changes(fmus, "plant.y.position_start=26mm")[0].startswith("plant.y.position_start = 26mm instead of 0.0")
    assert changes(fmus, "controller.antiwindup=false")[0].startswith("controller.antiwindup = false instead of")


def test_step_order_and_fmu(fmus: Path) -> None:
    plan = load_plan(RUN)
    shorter = prepare(plan, fmus, {}, {}, {"step": 0.1e-3, "order": "jacobi"}).provenance()
    assert shorter.differences == ("step = 0.0001 s instead of 0.0002 s", "order is jacobi")
    other = prepare(plan, fmus, {"controller": Replacement(FmuFile(fmus / "PID3DOF.fmu"))}, {})
    assert other.provenance().differences == ("controller is PID3DOF.fmu",)
    assert other.plan.title == plan.title, "what differs is said next to the title, not in it"


def test_a_modified_run_has_no_verdict_on_the_thesis(fastest_fmus: Path, tmp_path: Path) -> None:
    """Neither the run nor a comparison with it; what was measured stands next to the thesis's value, for who asks."""
    results = run_all(["3dof-pid-small"], out=tmp_path, fmus=fastest_fmus, set={"plant.y.mass": 8},
                      claims="thesis")
    judged = [claim for claims in results.verdicts.values() for claim in claims]
    assert judged
    assert {claim.verdict for claim in judged} <= {"modified run", "not testable"}
    assert any(claim.measured is not None for claim in judged)
    claims = (tmp_path / "claims.md").read_text()
    assert "`3dof-pid-small-pid` is a modified run: plant.y.mass = 8 kg instead of" in claims
    for verdict in ("| reproduced |", "not reproduced"):
        assert verdict not in claims
    text = (tmp_path / "3dof-pid-small-pid.txt").read_text()
    assert text.startswith("3dof-pid-small-pid: 3-DOF stage: a small step, PID\n")
    assert "modified: plant.y.mass = 8" in text
    data = json.loads((tmp_path / "3dof-pid-small-pid.json").read_text())
    assert data["provenance"]["modified"] is True
    assert data["provenance"]["changes"][0].startswith("plant.y.mass = 8 kg instead of")
    assert data["metrics"]["failed"] is False


def test_the_page_says_which_controller_ran(fastest_fmus: Path, tmp_path: Path) -> None:
    with warns("controller", "PID3DOF.fmu"):
        run_all([RUN], out=tmp_path, fmus=fastest_fmus, page=True, controller=fastest_fmus / "PID3DOF.fmu")
    page = (tmp_path / "report.html").read_text()
    assert "modified run: controller is PID3DOF.fmu" in page
    assert "(modified)" not in page
    assert 'data-verdict="reproduced"' not in page


def test_the_command_is_told(fastest_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["/somewhere/maglev", "run", "2dof-smooth-nonlinear", "--set", "plant.v.mass=3 kg"])
    maglev("run", "2dof-smooth-nonlinear", "--set", "plant.v.mass=3 kg", "--fmus", fastest_fmus, "--out",
           tmp_path)
    data = json.loads((tmp_path / "2dof-smooth-nonlinear.json").read_text())
    assert data["provenance"]["command"] == "maglev run 2dof-smooth-nonlinear --set 'plant.v.mass=3 kg'"
