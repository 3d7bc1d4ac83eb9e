"""Values that the thesis states, as marks in the panels."""

import pytest
from report_runs import packaged, page_of, recorded
from report_tab import Tab, wait_until

from maglev.pages.report_page import write_report
from maglev.runs.execution import RunResult
from maglev.runs.metrics import StepResponse
from maglev.runs.verdicts import ClaimResult
from maglev.scenario.claims import RunClaim

SETPOINTS = packaged("2dof-setpoints")
# Of v from 20 to 22 mm at 1 s, back by 4 mm at 6 s; of h at 1 s.
STEPS = tuple(StepResponse(*step, {1e-4: 0.4}, 0.2, 1e-6) for step in (
    ("v", 1.0, 0.020, 0.022), ("h", 1.0, 0.0, 0.003), ("v", 6.0, 0.022, 0.018)))


def run() -> RunResult:
    """A run of 8 s with three steps."""
    return recorded(SETPOINTS, 8.0, steps=STEPS)


def stated(source: str = "p. 53, Fig. 4.18", **table) -> ClaimResult:
    """A claim that the thesis makes of v."""
    return ClaimResult(RunClaim.model_validate({"text": "so it is", "source": source, **table}), 1.0, "reproduced")


def marks(*claims: ClaimResult, figure: str = "figure-4-18") -> list[tuple[str, float | None, float | None, float]]:
    """Kind of the panel, time, level and start of the marks of a figure, SI."""
    data = page_of([run()], {"2dof-setpoints": list(claims)}).data["figures"][figure]
    return [(data["panels"][mark["panel"]]["kind"], mark["time"], mark["level"], mark["start"])
            for mark in data["marks"]]


STEP = {"axis": "v", "relation": "<"}


@pytest.mark.parametrize(("table", "expected"), [
    # By when the error is within the band: after each step of the axis, unless the run has ended.
    ({"metric": "settling_time", "band": "0.1 mm", "target": "0.5 s", **STEP},
     [("error", 1.5, None, 0.0), ("error", 6.5, None, 0.0)]),
    ({"metric": "settling_time", "band": "0.1 mm", "target": "3 s", **STEP}, [("error", 4.0, None, 0.0)]),
    ({"metric": "settling_time", "band": "0.1 mm", "target": "3 s", **STEP, "over": "median"},
     [("error", 4.0, None, 0.0)]),
    # 50 % of 2 mm beyond 22 mm, of -4 mm beyond 18 mm.
    ({"metric": "overshoot", "target": 0.5, **STEP}, [("position", None, 0.023, 1.0), ("position", None, 0.016, 6.0)]),
    ({"metric": "overshoot", "target": 0.5, "over": "any", **STEP}, []),
    ({"metric": "steady_state_error", "target": "0.1 mm", **STEP},
     [("error", None, 1e-4, 1.0), ("error", None, 1e-4, 6.0)]),
    ({"metric": "highest", "column": "plant.v.encoder", "unit": "mm", "relation": "<", "target": 25.0},
     [("position", None, 0.025, 0.0)]),
    ({"metric": "failed", "relation": "is", "target": False}, []),
    ({"metric": "overshoot", "relation": "<", "factor": 0.5, "than": "2dof-step-4-linear"}, [])])
def test_where_a_stated_value_stands(table, expected):
    assert [tuple(pytest.approx(part) if isinstance(part, float) else part for part in mark)
            for mark in expected] == marks(stated(**table))


def test_of_currents_to_both_sides_and_only_in_the_figures_that_are_cited():
    claim = stated("p. 55, Fig. 4.20", metric="peak_command", relation="<", target="9 A")
    assert marks(claim) == []
    assert {(kind, level) for kind, _, level, _ in marks(claim, figure="figure-4-20")} == {
        ("commands", 9.0), ("commands", -9.0)}
    everywhere = stated("p. 53", metric="overshoot", target=0.5, **STEP)
    assert len(marks(everywhere)) == 2


def test_marks_are_drawn_and_named_next_to_the_curves(browser, tmp_path):
    claims = [stated(metric="settling_time", band="0.1 mm", target="0.5 s", **STEP),
              stated(metric="overshoot", target=0.5, **STEP)]
    write_report(tmp_path / "report.html", [run()], {"2dof-setpoints": claims})
    tab = Tab(browser, tmp_path / "report.html")
    tab.page.locator("#figure-4-18").scroll_into_view_if_needed()
    wait_until(tab.page, "document.querySelectorAll('#figure-4-18 .panel-plot .mark').length === 4")
    legends = tab.page.locator("#figure-4-18 .legend span").all_text_contents()
    words = {"thesis: settling time to 0.1 mm of v < 0.5 s", "thesis: overshoot of v < 50 %"}
    assert words <= {*legends} and words == {
        *tab.page.locator("#figure-4-18 .mark title").all_text_contents()}
    assert tab.page.locator("#figure-4-18 .panel-plot svg text").count() == 0, "no text covers a curve"
    tab.close()
