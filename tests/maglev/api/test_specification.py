"""A specification of one's own: claims in a user's scenario, judged whichever controller runs."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import maglev
from facts import raises
from report_runs import Page, judged, recorded, with_columns
from written_controllers import controller

from maglev.api.running import run_all
from maglev.files.errors import MeasurementError
from maglev.pages.figures import shown_figures
from maglev.pages.picture import figure_of
from maglev.pages.report_page import report_page
from maglev.pages.run_text import claims_markdown, study_tables
from maglev.runs.execution import judge_all
from maglev.runs.verdicts import specification
from maglev.scenario.loading import load_plan

SCENARIO = """
extends = "loops/2dof.toml"
name = "{name}"
title = "A short hold of mine"
stop_time = "{stop}"

[fmus.plant.start]
"v.position_start" = "21 mm"
"h.position_start" = "0 mm"

[[signals]]
to = "controller.v.reference"
kind = "constant"
value = "21 mm"
{claims}
"""

CLAIM = """
[[claims]]
text = "{text}"
source = "mine"
{criterion}
"""

HELD = CLAIM.format(text="It stays in the air", criterion='metric = "failed"\nrelation = "is"\ntarget = false')
WEAK = CLAIM.format(text="It needs hardly any current",
                    criterion='metric = "peak_current"\nrelation = "<"\ntarget = "1 mA"')
NEVER = CLAIM.format(text="It is faster", criterion='not_testable = "no stage"')


def scenario(folder: Path, *claims: str, name: str = "mine", stop: str = "20 ms") -> Path:
    """Write a scenario of one's own; returns its path."""
    path = folder / f"{name}.toml"
    path.write_text(SCENARIO.format(name=name, stop=stop, claims="".join(claims)), encoding="utf-8")
    return path


def verdicts(*arguments: str | Path) -> dict[str, str]:
    """Verdicts on the claims about the run "mine", as `maglev run --json` gives them."""
    result = maglev("run", *arguments, "--json")
    assert result.exit_code == 0, result.output
    return {claim["claim"]: claim["verdict"] for claim in json.loads(result.stdout)["runs"]["mine"]["claims"]}


def test_claims_are_met_or_not_whichever_controller_runs(fastest_fmus: Path, tmp_path: Path) -> None:
    path, out = scenario(tmp_path, HELD, WEAK), ("--fmus", fastest_fmus, "--out", tmp_path / "out")
    expected = {"It stays in the air": "met", "It needs hardly any current": "not met"}
    assert verdicts(path, *out) == expected
    assert verdicts(path, "--controller", controller(tmp_path), *out) == expected
    assert verdicts(path, "--set", "plant.v.mass=4", *out) == expected
    shown = maglev("run", path, *out).output
    assert "Your specification: 1 of 2 met" in shown
    assert "Claims of the thesis" not in shown


@pytest.mark.parametrize(("claims", "settings", "code", "said"), [
    ([HELD], [], 0, ""),
    ([WEAK], [], 1, "mine: not met: It needs hardly any current (peak current < 0.001 A: "),
    ([HELD], ["controller.current_limit=0.01"], 1, "mine: not met: It stays in the air"),
    ([], ["controller.current_limit=0.01"], 1, "mine: failed: stop on v at "),
    # A crash that is asked for.
    ([HELD.replace("false", "true")], ["controller.current_limit=0.01"], 0, ""),
    ([NEVER], [], 1, "mine: not testable: It is faster")])
def test_fail_on_claims(fastest_fmus: Path, tmp_path: Path, claims: list[str], settings: list[str], code: int,
                        said: str) -> None:
    path = scenario(tmp_path, *claims, stop="200 ms")
    arguments: list[str | Path] = ["run", path, "--fmus", fastest_fmus, "--out", tmp_path / "out",
                 *(word for setting in settings for word in ("--set", setting))]
    assert maglev(*arguments).exit_code == 0
    result = maglev(*arguments, "--fail-on-claims")
    assert result.exit_code == code, result.output
    assert said in result.stderr


@pytest.mark.parametrize(("added", "said"), [
    (CLAIM.format(text="Soon there", criterion='metric = "settling_time"\nband = "10 um"\nrelation = "<"\ntarget = 1'),
     "mine.toml: claim 'Soon there': the run has no settling_time to judge it on"),   # no reference steps
    ('[check.signals]\n"plant.v.position" = { absolute = "1 A" }',
     "absolute = '1 A': A given, expected a quantity in m")])
def test_refuses_criteria_that_no_run_can_decide(fastest_fmus: Path, tmp_path: Path, added: str,
                                                   said: str) -> None:
    """It would take the judgement of all other runs with it."""
    result = maglev("run", scenario(tmp_path, added), "--fmus", fastest_fmus, "--out", tmp_path / "out")
    assert (result.exit_code, list(tmp_path.glob("out/*.csv"))) == (2, [])
    assert said in result.stderr


def test_fail_on_claims_with_a_run_that_does_not_complete(fastest_fmus: Path, tmp_path: Path) -> None:
    broken = controller(tmp_path, ("w = self.bandwidth", "w = self.bandwidth / 0"))
    arguments = ("run", scenario(tmp_path, HELD), "--controller", broken, "--fmus", fastest_fmus,
                 "--out", tmp_path / "out")
    assert maglev(*arguments).exit_code == 2
    result = maglev(*arguments, "--fail-on-claims", "--json")
    assert result.exit_code == 2
    said = json.loads(result.stdout)
    assert said["missed"] == ["mine: did not complete"]
    assert said["runs"]["mine"]["outcome"] == "did not complete"


def test_a_comparison_is_with_the_run_as_it_is_planned(fastest_fmus: Path, tmp_path: Path) -> None:
    """Not with the controller that was put in on both sides, nor with its settings."""
    against = CLAIM.format(text="It needs less current", criterion='metric = "peak_current"\nrelation = "<"\n'
                                                                   'than = "2dof-smooth-nonlinear"')
    results = run_all([scenario(tmp_path, against)], controller=controller(tmp_path), fmus=fastest_fmus,
                      set={"controller.bandwidth": 50.0}, out=tmp_path / "out", say=lambda _: None)
    assert results.asked == ("mine",)
    mine, theirs = results.runs
    assert mine.modified and not theirs.modified
    (claim,) = results.verdicts["mine"]
    assert theirs.metrics is not None
    assert (claim.against, claim.verdict) == (theirs.metrics.motors[0].peak_current, "met")


def test_claims_of_a_run_that_a_file_extends_are_the_thesiss(tmp_path: Path) -> None:
    path = tmp_path / "heavier.toml"
    path.write_text('extends = "2dof-setpoints.toml"\nname = "heavier"\ntitle = "Heavier"\n'
                    '[fmus.plant.start]\n"v.mass" = "5 kg"\n', encoding="utf-8")
    plan = load_plan(path)
    assert plan.own and plan.claims and not any(claim.own for claim in plan.claims)
    with raises(MeasurementError, "`claims = []`"):
        judge_all([recorded(plan)])
    first = plan.model_copy(update={"claims": plan.claims[:1]})
    assert [claim.verdict for claim in judge_all([recorded(first)])["heavier"]] == ["modified run"]
    assert not load_plan("2dof-setpoints").own
    path.write_text(path.read_text(encoding="utf-8") + HELD, encoding="utf-8")
    assert [claim.own for claim in load_plan(path).claims] == [True]


def test_own_runs_are_shown_before_the_thesiss_and_apart(tmp_path: Path) -> None:
    mine, theirs = recorded(load_plan(scenario(tmp_path, HELD))), recorded(load_plan("2dof-setpoints"))
    found = {**judge_all([mine]), "2dof-setpoints": [judged("reproduced"), judged("not reproduced")]}
    assert [claim.verdict for claim in specification(found["mine"])] == ["met"]
    assert [str(table.title).strip() for table in study_tables([mine, theirs], found)] == [
        "Your runs", "Verdicts on the claims"]
    assert [str(table.title).strip() for table in study_tables([theirs], found)] == ["Verdicts on the claims"]
    own, thesis = claims_markdown([mine, theirs], found).split("\n# The thesis\n")
    assert own.startswith("# Your runs\n\n1 of 1 claims met.") and "`2dof-setpoints`" not in own
    assert "`mine`" not in thesis and "\n| all | 2 | 1 | 1 | – | – |\n" in thesis
    page = Page(report_page([mine, theirs], found))
    assert [body["id"] or body.text for body in page.all("tbody") if body["id"] or body["class"] == "part"] == [
        "Your runs", "run-mine", "The thesis", "run-2dof-setpoints"]
    assert page.all("figure")[0]["id"] == "figure-run-mine"
    assert "<strong>1 of 1</strong> of your claims are met." in page.source
    assert [table.text.replace("\n", "") for table in page.of_class("kinds")] == [
        "claimsspecifications✓ reproduced1✗ not reproduced1all2"]


@pytest.mark.usefixtures("slow")
def test_a_crash_early_on_is_drawn_around(tmp_path: Path) -> None:
    """Of 10 s, of which 9.95 are on the stop; a run that comes to a stop late, or none, is drawn whole."""
    pytest.importorskip("matplotlib")
    plan = load_plan(scenario(tmp_path))

    def drawn(**metrics: Any) -> tuple[float, str, float | None]:
        run = recorded(plan, stop_time=10.0, **metrics)
        figure = figure_of(run)
        (shown,) = shown_figures([], [run])
        times = [np.asarray(line.get_xdata()) for line in figure.axes[0].lines]
        return (max(each[-1] for each in times if len(each) > 2), figure.get_suptitle(), shown.figure.until)

    end, title, until = drawn(stop_contact=0.05, failed=True)
    assert (end, until) == (pytest.approx(0.25), pytest.approx(0.25))
    assert "the first 0.25 s of 10 s" in title
    assert drawn(stop_contact=0.001, failed=True)[2] == pytest.approx(0.1)
    for late in ({"stop_contact": 3.0, "failed": True}, {}):
        end, title, until = drawn(**late)
        assert (end, until) == (pytest.approx(10.0), None) and "the first" not in title


def test_outputs_of_ones_own_are_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    run = recorded(load_plan(scenario(tmp_path)))
    plain = figure_of(run)
    columns = {**run.columns, "controller.estimate": run.time, "controller.mode": run.time > 0.1}
    figure = figure_of(with_columns(run, columns))
    assert len(figure.axes) == len(plain.axes) + 2
    assert [line.get_label() for panel in figure.axes[-2:] for line in panel.lines] == ["controller.estimate"]
