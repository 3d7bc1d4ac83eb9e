import re
from dataclasses import replace
from typing import Literal

import pytest
from report_runs import Page, failed, judged, packaged, page_of, recorded, without_anything

from maglev.files.text_columns import unbroken
from maglev.pages.claim_table import linked_source
from maglev.pages.figures import read_figures, shown_figures
from maglev.pages.marks import cited_figures
from maglev.pages.run_text import sentence
from maglev.pages.what_if import Again
from maglev.runs.metrics import TrackingError
from maglev.runs.verdicts import VERDICTS, ClaimResult, Verdict
from maglev.scenario.claims import RunClaim
from maglev.scenario.layers import packaged_runs

SETPOINTS = packaged("2dof-setpoints")


def choices(page: Page) -> dict[str | None, str]:
    """Verdicts that can be chosen, with their words."""
    return {option["value"]: option.text for option in page.all("option") if option["value"] in ("", *VERDICTS)}


def test_the_summary_counts_verdicts_and_runs():
    claims = [judged(verdict) for k, verdict in enumerate(VERDICTS) for _ in range(k + 1)]
    page = page_of([recorded(SETPOINTS), failed(packaged("3dof-setpoints"), "why")], {"2dof-setpoints": claims})
    (table,) = page.of_class("kinds")
    words = ("reproduced", "within 10 %", "no difference", "not reproduced", "not testable", "not run", "modified run")
    rows = "".join(f"{sign} {word}{k}" for k, (sign, word) in enumerate(zip("✓≈=✗?–≠", words, strict=True), start=1))
    assert table.text.replace("\n", "") == f"claimsspecifications{rows}all28"
    assert "<p>8 of 17 axis-range checks are met.</p>" in page.source
    assert "1 of 2 runs did not complete." in page.source.replace("<strong>", "").replace("</strong>", "")
    assert [row["data-verdict"] for row in page.all("tr") if row["data-verdict"]] == [c.verdict for c in claims]
    options = choices(page)
    assert list(options) == ["", *VERDICTS]
    assert options[""] == "all (45)"
    assert options["not testable"] == "? not testable (5)"


def test_a_report_of_few_runs_begins_with_a_sentence_for_each():
    """How long it was simulated, its worst error, and how many of its claims hold: first, and not again."""
    claims = [judged("reproduced"), judged("not reproduced"), judged("not testable"), judged("met")]
    results = [recorded(SETPOINTS, end_errors={"v": 2e-6, "h": 1e-6})]
    page = page_of(results, {"2dof-setpoints": claims})
    words = unbroken("simulated for 0.5 s, completed; worst error at the end 2 µm on v; 1 of 2 claims hold")
    assert [each.text for each in page.of_class("said")] == [f"2dof-setpoints: {words}."]
    assert page.source.index('class="said"') < page.source.index("R. B. Owen")
    assert words not in page.with_id("figure-4-18").text and words in page.with_id("run-2dof-setpoints").text
    tracking = recorded(SETPOINTS, tracking=(TrackingError("h", 1e-4, 3e-4, 0.0),), failed=True,
                        tripped=0.25, trip_axis="h")
    assert sentence(tracking, []) == (
        "simulated for 0.5 s, failed: the controller tripped on h at 0.250 s; worst tracking error 0.3 mm on h")
    many = [recorded(packaged(name)) for name in packaged_runs() if name.startswith("2dof-step")]
    told = page_of(many)
    assert len(many) > 4 and told.of_class("said") == []
    assert unbroken("simulated for 0.5 s, completed") in told.with_id("figure-4-22").text


def test_a_claim_shows_everything_that_is_known():
    page = page_of([recorded(SETPOINTS)], {"2dof-setpoints": [judged("not reproduced", reason="friction is assumed")]})
    row = page.with_id("claim-2dof-setpoints-0")
    for text in ("The overshoot is below 30 %", "p. 53, Fig. 4.18", "overshoot < 30 %", "25 %", "✗ not reproduced",
                 "friction is assumed"):
        assert text in row.text.replace("\N{NO-BREAK SPACE}", " ")


def test_other_readings_are_shown_beside_the_counts():
    claims = [judged("reproduced"), replace(judged("reproduced"), counts=False), judged("not run")]
    page = page_of([recorded(SETPOINTS)], {"2dof-setpoints": claims})
    assert choices(page) == {"": "all (2 + 1 of other readings)", "not run": "– not run (1)",
                             "reproduced": "✓ reproduced (1 + 1 of other readings)"}


def test_the_report_says_how_many_runs_it_has_and_when_it_was_made(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")
    page = page_of([recorded(SETPOINTS)])
    (words,) = [line for line in page.source.splitlines() if 'class="origin"' in line and "package" in line]
    assert re.search(r">1 of the \d+ runs of the package, 2001-09-09", words)
    assert 'class="search" hidden' in page.source, "of one run without claims there is nothing to search for"
    mine = page_of([recorded(without_anything("mine"))]).source
    assert 'class="origin">2001-09-09' in mine and "Numbered as in the thesis" not in mine


def test_what_cannot_be_tested_has_its_reason():
    page = page_of([recorded(SETPOINTS)], {"2dof-setpoints": [judged("not testable", reason="no such stage")]})
    assert "no such stage" in page.with_id("claim-2dof-setpoints-0").text


def test_a_failed_run_is_shown_with_what_went_wrong():
    page = page_of([recorded(packaged("2dof-step-4-nonlinear")),
                    failed(packaged("2dof-step-4-linear"), "plant: fmi2DoStep failed at 2.1 s")],
                   {"2dof-step-4-linear": [judged("not run")]})
    message = "did not complete: plant: fmi2DoStep failed at 2.1 s"
    assert message in page.with_id("run-2dof-step-4-linear").text
    assert message in page.with_id("figure-4-25").text
    assert "– not run" in page.with_id("claim-2dof-step-4-linear-0").text
    assert "2dof-step-4-linear" not in page.data["runs"]


def test_a_run_that_touches_a_stop_and_trips_says_so():
    page = page_of([recorded(SETPOINTS, failed=True, stop_contact=0.125, tripped=0.25)])
    for identifier in ("run-2dof-setpoints", "figure-4-18"):
        assert "touched an end stop at 0.125 s" in page.with_id(identifier).text
        assert "the controller tripped at 0.250 s" in page.with_id(identifier).text
    assert page.data["runs"]["2dof-setpoints"]["events"] == [
        {"time": 0.125, "text": "touched an end stop at 0.125 s"},
        {"time": 0.25, "text": "the controller tripped at 0.250 s"}]


def test_a_run_without_claims_says_so():
    assert "no claims" in page_of([recorded(SETPOINTS)]).with_id("run-2dof-setpoints").text


def test_a_figure_lists_the_claims_that_cite_it():
    claims = [judged("reproduced", text=f"from {source}", source=source)
              for source in ("Fig. 4.18", "Figs. 4.18-4.20", "p. 53", "Fig. 4.20; (4.19)")]
    page = page_of([recorded(SETPOINTS)], {"2dof-setpoints": claims})
    assert "from Figs. 4.18-4.20" in page.with_id("figure-4-19").text
    assert "(4.19)" not in page.with_id("figure-4-19").text
    assert "from Fig. 4.18" in page.with_id("figure-4-18").text
    assert "from p. 53" not in page.with_id("figures").text


@pytest.mark.parametrize(("source", "numbers"), [
    ("p. 53, Fig. 4.18", {"4.18"}),
    ("Figs. 5.34-5.36", {"5.34", "5.35", "5.36"}),
    ("Figures 4.18, 4.19 and 4.21", {"4.18", "4.19", "4.21"}),
    ("section 4.1.3, (4.12)", set()),
    ("p. 57, Fig. 4.26; the figure of 50 % is assumed", {"4.26"}),
])
def test_cited_figures(source, numbers):
    assert cited_figures(source) == numbers


def test_a_source_links_to_the_figures_of_the_page_only():
    shown = shown_figures(read_figures(), [recorded(SETPOINTS)])
    assert linked_source("Figs. 4.18, 5.20 & (4.19)", shown) == (
        'Figs. <a href="#figure-4-18">4.18</a>, 5.20 &amp; (4.19)')


def blaming(verdict: Verdict, because: Literal["friction"] | None = "friction") -> ClaimResult:
    """A claim whose reason blames friction, as it is marked, or has one that is not."""
    claim = RunClaim(text="It settles at once", source="p. 53, Fig. 4.18", metric="overshoot", relation="<", target=0.3,
                     reason="guide friction slows it", because=because)
    return ClaimResult(claim, 0.35, verdict)


def test_the_message_counts_claims_and_those_that_blame_friction():
    """Not what merely mentions friction, nor bounds, nor claims that reproduce or come close."""
    claims = [judged("reproduced"), blaming("within 10 %"), judged("not met"),
              *(blaming("not reproduced") for _ in range(2)), *(blaming("not reproduced", None) for _ in range(3))]
    (message,) = page_of([recorded(SETPOINTS)], {"2dof-setpoints": claims}).of_class("message")
    assert message.text == ("1 of 7 specifications reproduce. Of the 5 that do not, 2 have guide friction "
                            "among the reasons: the thesis does not state it, so it is assumed here.")


def test_a_claim_that_blames_friction_says_what_comes_out_without_it():
    without = replace(blaming("reproduced"), measured=0.2)
    claims = [replace(blaming("not reproduced"), without=without), blaming("not reproduced")]
    again = recorded(SETPOINTS)
    page = page_of([recorded(SETPOINTS)], {"2dof-setpoints": claims}, frictionless=Again([again]))
    told = [element.text for element in page.of_class("what-if") if element.tag == "details"]
    # Next to the figure that the claim cites, and in the table.
    said = "What if friction were zero?✓ reproduced: 20\N{NO-BREAK SPACE}%."
    assert told == [said, f"{said} Its curves in Figure 4.18"]
    assert [button["data-switch"] for button in page.all("button") if "data-switch" in button.attributes] == [
        name for name, figure in page.data["figures"].items() if "without" in figure] != []
    signals = page.data["runs"]["2dof-setpoints, without friction"]["signals"]
    assert "plant.v.position" in signals
    assert not [name for name in signals if ".i_" in name]


def test_without_verdicts_there_is_no_message():
    assert page_of([recorded(SETPOINTS)], {"2dof-setpoints": [judged("not run")]}).of_class("message") == []


def test_under_a_figure_its_claims_have_value_criterion_and_reason():
    claim = judged("not reproduced", reason="friction is assumed")
    text = page_of([recorded(SETPOINTS)], {"2dof-setpoints": [claim]}).with_id("figure-4-18").text
    assert f"{claim.claim.text} ({claim.claim.criterion}). Measured: 25" in text.replace("\N{NO-BREAK SPACE}", " ")
    assert text.rstrip().endswith(" whyfriction is assumed")   # folded
