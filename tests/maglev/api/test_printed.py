"""Runs, results, verdicts and comparisons print as the tables of the terminal, and show them in a notebook."""

import math
from typing import Any

import numpy as np
import pytest
from report_runs import judged, packaged, recorded
from rich.console import Console

import maglev
from maglev.cosim.master import Recording
from maglev.pages.run_text import REPORT_WIDTH, Verdicts
from maglev.runs.execution import RunResult

NAME = "2dof-setpoints"


PLAN = packaged(NAME).model_copy(update={"claims": []})
CLAIMS = [judged("reproduced"), judged("not reproduced")]


def run_of(**metrics: Any) -> maglev.Run:
    return maglev.Run(recorded(PLAN, **metrics), {})


def results_of() -> maglev.Results:
    return maglev.Results((NAME,), (recorded(PLAN),), (), {NAME: Verdicts(CLAIMS)}, (), {NAME: {}})


def comparison_of() -> maglev.Comparison:
    runs = {label: run_of(rms_errors={"v": error, "h": error}) for label, error in (("mine", 1e-5), ("old", 3e-5))}
    return maglev.Comparison(NAME, "Two of them", runs, {}, {label: run.result for label, run in runs.items()})


@pytest.mark.parametrize(("shown", "words"), [
    (run_of(rms_errors={"v": 1e-5}), [NAME, "10 µm"]), (Verdicts(CLAIMS), ["Claims of the thesis", "30 %"]),
    (results_of(), ["Claims of the thesis", f"{NAME}: "]),
    (comparison_of(), ["rms error", "30 µm", "mine is better in 2 of 2 rows about axes"])],
    ids=["run", "verdicts", "results", "comparison"])
def test_they_print_as_tables_and_show_them(shown: Any, words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    print(shown)
    text, html = capsys.readouterr().out, shown._repr_html_()
    plain = Console(width=REPORT_WIDTH, force_terminal=False, markup=False)
    with plain.capture() as captured:
        shown.show(plain)
    assert text == f"{captured.get()}\n"   # what a command prints
    assert "ClaimResult(" not in text
    assert max(map(len, text.splitlines())) <= REPORT_WIDTH
    assert all(word in " ".join(text.split()) for word in words)
    assert html.startswith("<pre") and words[0] in html


def test_verdicts_are_a_tuple_that_shows_itself() -> None:
    verdicts = Verdicts(CLAIMS)
    assert list(verdicts) == CLAIMS
    assert repr(verdicts) == str(verdicts)
    assert list(map(repr, CLAIMS)) == [f"<ClaimResult {each.verdict}: {each.claim.text}>" for each in CLAIMS]
    assert str(run_of().verdicts).strip() == "no claims"


def test_a_run_that_cannot_be_measured_says_so() -> None:
    recording = Recording(np.array([0.0]), {"plant.v.position": np.array([math.nan])})
    run = maglev.Run(RunResult(PLAN, recording), {}, recording)
    assert "cannot be measured" in str(run)
