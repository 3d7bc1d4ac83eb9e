"""What procedures found, in the terminal and in files."""

import csv
import math
import re
from dataclasses import replace
from io import StringIO
from typing import Any

import numpy as np
import pytest
from report_outcomes import GAP, HOSTILE, THRUST, chart, cogging_claim, hostile_outcome, outcome
from report_runs import failed, judged, packaged, recorded, without_anything
from rich.console import Console
from rich.text import Text

from maglev.cli.terminal import report_console
from maglev.files.pictures import write_figure
from maglev.pages.picture import figure_of, overlay
from maglev.pages.plot_data import run_signals
from maglev.pages.run_text import (
    REPORT_WIDTH,
    claims_markdown,
    curves_csv,
    outcome_text,
    run_text,
    short_outcome,
    study_table,
    write_outcomes,
)
from maglev.pages.shell import colour
from maglev.runs.metrics import StepResponse
from maglev.runs.procedure_outcome import Chart, Curve, Panel
from maglev.runs.procedures import judge_procedure
from maglev.scenario.run_plan import Event

RUN = recorded(packaged("2dof-setpoints"))


def text_of_one(found) -> str:
    return outcome_text(found, judge_procedure(found))


def table_text(*arguments) -> str:
    text = StringIO()
    Console(file=text, width=120).print(study_table(*arguments))
    return text.getvalue()


def cells(line: str) -> list[str]:
    """Cells of a line of a table: two spaces or more are between them."""
    return re.split(" {2,}", line.strip())


def rows_of(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(StringIO(text)))


def test_title_tables_notes_and_claims_are_printed_in_this_order():
    text = text_of_one(outcome())
    places = [text.index(words) for words in ("2dof-thrust: Thrust by parabolas", "Constants", "14.2", "791",
                                              "note: C3 is not excited.", "Claims of the thesis", "reproduced")]
    assert places == sorted(places)
    assert "claim" not in text_of_one(outcome(claims=(), tables=(), notes=()))


def test_texts_are_no_markup():
    text = " ".join(text_of_one(hostile_outcome()).split())
    assert f"2dof-thrust: {HOSTILE}" in text
    assert f"note: {HOSTILE}" in text
    assert text.count("[red]") > 4
    claim = judged("not reproduced", text="[bold]a[/]", source="[/red]", reason="[b]")
    printed = run_text(RUN, [claim])
    for words in ("[bold]a[/]", "[/red]", "; [b]"):
        assert words in " ".join(printed.split())


def test_texts_are_neither_control_sequences_nor_html(capsys: pytest.CaptureFixture[str]):
    """Of a scenario file of others, or by an FMU: no colours, no clearing of the screen, no letters that turn round."""
    hostile = "\x1b[2Jgone \x9b31m \u202edetrever <script>alert(1)</script> <img src=x> <!-- 1 < 2"
    claim = judged("not reproduced", text=hostile, source=hostile, reason=hostile)
    report_console().print(Text(hostile))
    for printed in (run_text(RUN, [claim]), capsys.readouterr().out):
        assert "\\x1b[2Jgone" in printed
        assert not set("\x1b\x9b\u202e") & set(printed)
    markdown = claims_markdown([RUN], {RUN.plan.name: [claim]})
    assert markdown.count("\\x1b[2Jgone \\x9b31m \\u202edetrever &lt;script>alert(1)&lt;/script> &lt;img src=x> "
                          "&lt;!-- 1 < 2") == 3


def test_curves_are_written_in_long_form():
    rows = rows_of(curves_csv([chart(panels=2), chart("5.1"), chart(None)]))
    assert list(rows[0]) == ["figure", "panel", "curve", "x", "y", "margin"]
    assert list(rows[0].values()) == ["4.9", f"1: {THRUST} over {GAP}", "parabola fit", "10.0", repr(1.0 / 3.0), "0.05"]
    assert len(rows) == 4 * 5
    assert {(row["figure"], row["panel"][:1]) for row in rows} == {
        ("4.9", "1"), ("4.9", "2"), ("5.1", "1"), ("Thrust over the air gap.", "1")}


@pytest.mark.parametrize("value", [1.0 / 3.0, 1e-300, float("inf")])
def test_reading_a_curve_gives_the_same_bits(value):
    panel = Panel(GAP, THRUST, (Curve('a "b", c', np.array([value]), np.array([2])),))
    (row,) = rows_of(curves_csv([Chart("4.9", "", (panel,))]))
    assert float(row["x"]) == value
    assert row["y"] == "2.0"
    assert row["curve"] == 'a "b", c'


def test_files_are_named_after_the_procedure(tmp_path):
    outcomes = [outcome("a"), outcome("b", charts=())]
    files = write_outcomes(outcomes, {found.settings.name: judge_procedure(found) for found in outcomes}, tmp_path)
    assert [path.name for path in files] == ["a.txt", "a.curves.csv", "b.txt"]
    assert {path.name for path in tmp_path.iterdir()} == {"a.txt", "a.curves.csv", "b.txt"}
    assert (tmp_path / "a.txt").read_text() == text_of_one(outcomes[0])


def test_claims_of_procedures_are_counted_after_those_of_the_runs():
    found = outcome(claims=(cogging_claim(), cogging_claim("a | b")))
    judgements = {"2dof-setpoints": [judged("not run")], "2dof-thrust": judge_procedure(found)}
    text = claims_markdown([RUN], judgements, [found])
    assert text.startswith("3 claims on 1 run and 1 procedure.\n\n| what is claimed | claims | reproduced | not run |")
    assert ("\n| printed numbers | 2 | 2 | – | – | – |\n| specifications | 1 | – | 1 | – | – |\n"
            "| all | 3 | 2 | 1 | – | – |\n" in text)
    lines = [line for line in text.splitlines() if line.startswith(("| `", "## "))]
    assert [line.split("|")[-1 if line[0] == "#" else 1].strip() for line in lines] == [
        "## Printed numbers", "`2dof-thrust`", "`2dof-thrust`", "## Specifications", "`2dof-setpoints`"]
    assert "| cogging force about 2 N | 2.1 N | reproduced |" in lines[1]
    assert "a \\| b" in lines[2]


def test_without_procedures_the_table_is_as_it_was():
    judgements = {"2dof-setpoints": [judged("not run")]}
    assert claims_markdown([RUN], judgements).startswith("1 claim on 1 run.\n")
    assert "procedure" not in table_text([RUN], judgements)
    assert table_text([RUN], judgements) == table_text([RUN], judgements, [])


def test_the_table_of_many_runs_has_the_procedures():
    found = [outcome(), outcome("3dof-thrust", claims=())]
    judgements = {"2dof-setpoints": [judged("reproduced")], **{each.settings.name: judge_procedure(each)
                                                               for each in found}}
    lines = table_text([RUN], judgements, found).splitlines()
    (own,) = [line for line in lines if "2dof-thrust" in line]
    assert [cells(line)[:3] for line in lines if "1 claim " in line] == [
        ["printed numbers", "1 claim", "1"], ["specifications", "1 claim", "1"]]
    assert cells(own)[:3] == ["2dof-thrust", "1 value", "1"]
    assert any("3dof-thrust" in line and "no claims" in line for line in lines)
    assert cells(lines[-1])[:3] == ["1 runs", "2 procedures", "2"]


@pytest.mark.usefixtures("slow")
def test_a_run_without_axes_or_motors_has_a_picture(tmp_path):
    pytest.importorskip("matplotlib")
    plan = packaged("2dof-setpoints").model_copy(update={"axes": {}})
    for name, each in (("a.png", plan), ("b.png", without_anything("mine"))):
        result = recorded(each)
        write_figure(tmp_path / name, figure_of(result))
        assert (tmp_path / name).stat().st_size > 0


def points_of(line: Any) -> np.ndarray:
    """Points of a line that matplotlib draws, shape (n, 2)."""
    return np.asarray(line.get_xydata())


def test_a_picture_has_two_panels_for_each_axis_and_motor_and_every_sample():
    pytest.importorskip("matplotlib")
    panels = figure_of(RUN).axes
    assert [panel.get_ylabel() for panel in panels] == [
        "gap v (mm)", "|error| of gap v (mm)", "h (mm)", "|error| of h (mm)", "motor commands (A)",
        "motor currents (A)"]
    reference, position = panels[0].get_lines()
    np.testing.assert_allclose(points_of(position)[:, 1] - points_of(reference)[:, 1], -1.0)   # mm
    assert len(points_of(position)) == len(RUN.time)


def test_windows_of_events_are_drawn_in_every_picture():
    pytest.importorskip("matplotlib")
    events = [Event(name="push", time=0.1, end=0.3), Event(name="other", time=0.4)]
    run = replace(RUN, plan=RUN.plan.model_copy(update={"events": events}))
    assert [each[:2] for each in run_signals(run, [], 1000, ())["windows"]] == [("push", 0.1), ("other", 0.4)]
    figure = figure_of(run)
    assert [[note.get_text() for note in panel.texts] for panel in figure.axes[:3]] == [["push", "other"]] * 2 + [[]]
    assert all(len(panel.patches) == 2 for panel in figure.axes)


def test_a_picture_marks_limits_that_are_near_and_when_a_stop_was_touched():
    pytest.importorskip("matplotlib")
    parameters = {"plant.v.stop.lower": 0.018, "plant.v.stop.upper": 0.1, "plant.motor.amplifier.peak": 2.5,
                  "controller.current_limit": 0.0}
    result = recorded(packaged("2dof-setpoints"), stop_contact=0.125)
    figure = figure_of(replace(result, parameters=parameters))
    levels, instants = {}, []
    for panel in figure.axes:
        lines = [line for line in map(points_of, panel.get_lines()) if len(line) == 2]
        levels[panel.get_ylabel()] = [line[0, 1] for line in lines if line[0, 1] == line[1, 1] and "|" not in
                                      panel.get_ylabel()]
        instants += [line[0, 0] for line in lines if line[0, 0] == line[1, 0]]
    assert levels["gap v (mm)"] == [18.0]   # the upper one is far
    assert levels["motor currents (A)"] == [-2.5, 2.5]
    assert levels["motor commands (A)"] == levels["h (mm)"] == []
    assert instants == [0.125] * len(figure.axes)
    assert figure.get_suptitle().endswith("touched an end stop at 0.125 s (dashed)")


@pytest.mark.parametrize(("metrics", "text", "cell"), [
    ({"failed": True, "tripped": 0.25, "stop_contact": 0.125},
     "failed: touched an end stop at 0.125 s, the controller tripped at 0.250 s", "failed: stop at 0.125 s"),
    ({"failed": True, "tripped": 0.25, "trip_axis": "v", "stop_contact": 0.375},
     "failed: the controller tripped on v at 0.250 s, touched an end stop at 0.375 s",
     "failed: trip on v at 0.250 s"),
    ({"end_errors": {"v": 1e-6, "h": 1.04e-3}, "ended_off": {"h": 1.04e-3}}, "ended off target: 1.04 mm on h",
     "ended off target: 1.04 mm on h"),
    ({"end_errors": {"v": 1e-6, "h": 2e-3}}, "completed: largest end error 2 mm on h", "completed, 2 mm on h"),
    ({}, "completed", "completed")])
def test_the_ending_has_events_in_order_of_time(metrics, text, cell):
    result = recorded(packaged("2dof-setpoints"), **metrics)
    assert run_text(result, []).splitlines()[-1] == text
    assert short_outcome(result) == cell


def test_rotations_are_printed_in_mrad():
    plan = packaged("2dof-setpoints")
    plan = plan.model_copy(update={
        "axes": {**plan.axes, "h": plan.axes["h"].model_copy(update={"rotation": True})},
        "metrics": plan.metrics.model_copy(update={"tilt_bands": [0.5e-3]})})
    steps = (StepResponse("v", 1.0, 0.02, 0.022, dict.fromkeys(plan.metrics.bands, 0.5), 0.1, 2e-6),
             StepResponse("h", 1.0, 0.0, 0.01, {0.5e-3: 0.25}, 0.2, 3e-6))
    text = run_text(recorded(plan, steps=steps, end_errors={"v": 2e-6, "h": 2e-3}), [])
    assert [cell in text for cell in ("10 mrad", "0.5 mrad", "3 µrad", "22 mm", "2 µm")] == 5 * [True]
    assert text.splitlines()[-1] == "completed: largest end error 2 µm on v, largest end error 2 mrad on h"


def test_the_window_of_a_step_is_printed_with_what_cut_it_short():
    plan = packaged("2dof-setpoints")
    steps = tuple(StepResponse("v", time, 0.02, 0.022, dict.fromkeys(plan.metrics.bands, math.inf), 0.1, 2e-6, end, by)
                  for time, end, by in ((1.0, 6.0, "push"), (6.5, 8.25, "")))
    text = run_text(recorded(plan, steps=steps), [])
    assert max(map(len, text.splitlines())) <= REPORT_WIDTH
    rows = [" ".join(line.split()) for line in text.splitlines()]
    assert any(row.startswith("1 to 6 s,") for row in rows)
    assert any(row.startswith("6.5 to 8.25 s v 20 mm 22 mm") for row in rows)


def test_a_run_that_did_not_complete_has_its_reason():
    result = failed(packaged("2dof-setpoints"), "[b] no step")
    assert run_text(result, []).splitlines()[1] == short_outcome(result) == "did not complete: [b] no step"


def test_a_run_without_axes_and_motors_is_printed():
    text = run_text(recorded(without_anything("mine")), [])
    assert text.endswith("\ncompleted\n")
    assert "Currents" not in text


def test_runs_over_each_other_have_each_limit_once_and_their_own_events():
    pytest.importorskip("matplotlib")
    result = recorded(RUN.plan, stop_contact=0.125)
    parameters = {"plant.v.stop.lower": 0.018, "plant.v.stop.upper": 0.031}
    wild = replace(result, parameters=parameters)
    figure = overlay("both", {"calm": replace(wild, metrics=None), "wild": wild})
    position = figure.axes[0]
    legend = position.get_legend()
    assert legend and [text.get_text() for text in legend.get_texts()] == ["reference", "calm", "wild", "end stops"]
    assert [points_of(line)[0, 1] for line in position.lines if line.get_linestyle() == "-."] == [18.0, 31.0]   # mm
    for panel in figure.axes:
        event = panel.lines[-1]
        assert (points_of(event)[0, 0], event.get_color()) == (0.125, colour("run-1"))   # s; of the second run
    assert figure.get_suptitle() == "both\nwild touched an end stop at 0.125 s (dashed)"


def test_a_far_limit_stays_out_whatever_other_marks_widen():
    pytest.importorskip("matplotlib")
    low, high = sorted(figure_of(RUN).axes[0].get_ylim())   # a gap grows downwards
    near, far = low - 0.9 * (high - low), high + 1.2 * (high - low)   # mm
    drawn = replace(RUN, parameters={"plant.v.stop.lower": 1e-3 * near, "plant.v.stop.upper": 1e-3 * far})
    panel = overlay("both", {"one": drawn, "other": drawn}).axes[0]
    assert [points_of(line)[0, 1] for line in panel.lines if line.get_linestyle() == "-."] == [pytest.approx(near)]


def test_another_reading_is_shown_and_not_counted():
    other = replace(RUN, plan=RUN.plan.model_copy(update={"name": "other"}))
    judgements = {"2dof-setpoints": [judged("reproduced")], "other": [replace(judged("reproduced"), counts=False)]}
    text = claims_markdown([RUN, other], judgements)
    assert text.startswith("1 claim on 2 runs.\n") and "\n| all | 1 | 1 | – | – |\n" in text
    assert "| **reproduced**: another reading of the experiment, not counted |" in text.rstrip().splitlines()[-1]
    rows = map(cells, table_text([RUN, other], judgements).splitlines())
    assert [row[-1] for row in rows if row[0] in ("other", "2 runs")] == ["1", "1"]
