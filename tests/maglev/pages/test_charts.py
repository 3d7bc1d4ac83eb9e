"""Charts, tables and notes of procedures on the page."""

import numpy as np
import pytest
from report_outcomes import GAP, HOSTILE, THRUST, chart, cogging_claim, hostile_outcome, outcome
from report_runs import Page, failed, judged, of_procedure, packaged, page_of, recorded, renamed

from maglev.files.text_columns import unbroken
from maglev.pages.charts import MOST_POINTS, by_number, chart_data, curve_data, shown_charts
from maglev.pages.claim_table import linked_source
from maglev.pages.figures import read_figures, shown_figures
from maglev.pages.report_page import SCRIPTS
from maglev.runs.procedure_outcome import Chart, Curve, Outcome, Panel, ProcedureValue

SETPOINTS = packaged("2dof-setpoints")
CHART = "figure-4-9-2dof-thrust"


@pytest.fixture(scope="module")
def page() -> Page:
    """Page of a run, a procedure, and two runs of it, one of which failed."""
    runs = [recorded(SETPOINTS), recorded(of_procedure("2dof-setpoints", "parabola", claims=[])),
            failed(of_procedure("2dof-setpoints", "broken", claims=[]), "no step")]
    return page_of(runs, {"2dof-setpoints": [judged("not run")]}, [outcome()])


def test_a_chart_is_a_figure_with_its_claims(page):
    figure = page.with_id(CHART)
    assert figure.tag == "figure"
    for text in ("Figure 4.9", "Thrust over the air gap.", "2dof-thrust", "✓ reproduced The cogging force is 2 N"):
        assert text in figure.text
    assert CHART in page.attributes("data-figure")
    assert page.data["figures"][CHART] == {"runs": [], "chart": [{"x": GAP, "y": THRUST, "curves": [
        {"label": "parabola fit", "kin": "parabola fit", "marked": False,
         "x": [10.0, 15.0, 20.0], "y": [0.333333, 0.25, 0.125], "margin": [0.05, 0.0333333, None]},
        {"label": "estimator", "kin": "estimator", "marked": True, "x": [10.0, 20.0], "y": [0.3, 0.1]}]}]}


def test_the_claims_of_a_procedure_are_a_group_of_the_table(page):
    group = page.with_id("procedure-2dof-thrust")
    assert group.tag == "tbody"
    for text in ("2dof-thrust Thrust by parabolas", "Figure 4.9, Tables"):
        assert text in group.text
    row = page.with_id("claim-2dof-thrust-0")
    assert row["data-verdict"] == "reproduced"
    for text in ("p. 34, Fig. 4.9", "cogging force about 2 N", "2.1 N"):
        assert text in row.text.replace("\N{NO-BREAK SPACE}", " ")
    assert f'Fig. <a href="#{CHART}">4.9</a>' in page.source


def test_the_claims_of_procedures_are_counted(page):
    assert page.of_class("kinds")[0].text == (
        "claimsprinted numbersspecificationsall\n✓ reproduced1–1\n– not run–11\nall112")
    assert [option.text for option in page.all("option")][-3:] == [
        "all (2)", "✓ reproduced (1)", "– not run (1)"]


def test_tables_and_notes_follow_the_claims(page):
    section = page.with_id("identification")
    assert section.text.index("Constants") < section.text.index("C3 is not excited.")
    _, opening, rest = page.source.partition('<section id="identification">')
    alone = Page(opening + rest.partition("</section>")[0] + "</section>")
    (table,) = alone.of_class("values")
    assert [cell.text for cell in alone.all("th") if cell["scope"] == "row"] == ["C1", "C2"]
    assert "C114.214.1" in table.text
    parts = [page.source.index(f'id="{name}"') for name in ("figures", "claims", "identification")]
    assert parts == sorted(parts)
    assert '<a href="#identification">' in page.source


def test_every_link_has_its_target_and_every_id_is_unique(page):
    identifiers = page.attributes("id")
    assert len(set(identifiers)) == len(identifiers)
    assert {(link["href"] or "")[1:] for link in page.all("a")} <= set(identifiers)


def test_runs_of_a_procedure_are_in_the_table_only_if_they_failed(page):
    identifiers = page.attributes("id")
    assert "run-parabola" not in identifiers
    assert "did not complete: no step" in page.with_id("run-broken").text
    assert "parabola: " in page.with_id("assumptions").text
    assert "parabola" not in page.data["runs"]


def test_a_run_of_a_procedure_in_a_figure_of_the_thesis_has_no_dead_link():
    page = page_of([recorded(of_procedure("2dof-setpoints", "2dof-setpoints", claims=[]))], {}, [outcome()])
    assert "2dof-setpoints" in page.with_id("figure-4-18").text
    assert {(link["href"] or "")[1:] for link in page.all("a")} <= set(page.attributes("id"))
    assert "2dof-setpoints" in page.data["runs"]


def test_without_tables_and_notes_there_is_no_section():
    page = page_of([], {}, [outcome(tables=(), notes=())])
    assert "identification" not in page.attributes("id")
    assert "#identification" not in page.source
    assert page.with_id("procedure-2dof-thrust").text.count("Figure 4.9") == 1
    assert "Tables" not in page.with_id("procedure-2dof-thrust").text
    assert "figure-4-9-2dof-thrust" in page.attributes("data-figure")


def test_a_procedure_without_claims_says_so():
    group = page_of([], {}, [outcome(claims=(), tables=())]).with_id("procedure-2dof-thrust")
    assert "no claims" in group.text
    assert "Notes" in group.text


def test_charts_stand_among_the_figures_by_number():
    charts = [chart(number) for number in ("5.7", "4.10", "4.8", "4.18", None)]
    results = [recorded(SETPOINTS), recorded(packaged("3dof-setpoints")), recorded(renamed("2dof-setpoints", "mine"))]
    shown = by_number(shown_figures(read_figures(), results), shown_charts([outcome(charts=tuple(charts))]))
    numbers = [each.number for each in shown]
    assert numbers[:3] == ["4.8", "4.10", "4.18"]
    assert [each.id for each in shown if each.number == "4.18"] == ["figure-4-18", "figure-4-18-2dof-thrust"]
    assert numbers.index("4.21") < numbers.index("5.7") < numbers.index("5.20")
    assert [each.title for each in shown[-2:]] == ["Run mine", "Thrust by parabolas"]


def test_without_charts_the_figures_keep_their_order():
    shown = shown_figures(read_figures(), [recorded(SETPOINTS), recorded(renamed("2dof-setpoints", "mine"))])
    assert by_number(shown, []) == shown


def test_charts_of_one_number_have_anchors_of_their_own():
    shown = [*shown_charts([outcome(charts=(chart(), chart())), outcome("3dof-thrust")])]
    assert [each.id for each in shown] == [CHART, f"{CHART}-2", "figure-4-9-3dof-thrust"]


def test_a_claim_links_to_the_chart_of_its_own_procedure():
    claims = (cogging_claim(source="Figs. 4.9, 4.18 and 4.30"),)
    page = page_of([recorded(SETPOINTS)], {}, [outcome("2dof-thrust"), outcome("3dof-thrust", claims=claims)])
    assert ('Figs. <a href="#figure-4-9-3dof-thrust">4.9</a>, <a href="#figure-4-18">4.18</a> and 4.30'
            in page.source)
    assert linked_source("Fig. 4.9", shown_charts([outcome()])) == f'Fig. <a href="#{CHART}">4.9</a>'


def test_a_chart_lists_the_claims_that_cite_it():
    claims = tuple(cogging_claim(f"from {source}", source) for source in ("Figs. 4.8-4.10", "Fig. 4.90", "(4.9)"))
    page = page_of([recorded(SETPOINTS)], {"2dof-setpoints": [judged("not run", "of a run", "Fig. 4.9")]},
                   [outcome(claims=claims, runs=("2dof-setpoints",))])
    text = page.with_id(CHART).text
    assert "from Figs. 4.8-4.10" in text
    assert "of a run" in text
    assert "4.90" not in text
    assert "(4.9)" not in text


def test_a_chart_of_several_panels_is_higher():
    heights = []
    for panels in (1, 3):
        page = page_of([], {}, [outcome(charts=(chart(panels=panels),))])
        assert len(page.data["figures"][CHART]["chart"]) == panels
        (plot,) = page.of_class("plot")
        heights.append(int((plot["style"] or "").removeprefix("min-height:").removesuffix("px")))
    assert heights[1] > 2 * heights[0]


def test_text_is_escaped():
    page = page_of([], {}, [hostile_outcome()])
    assert len(page.all("script")) == 4 + len(SCRIPTS)   # the index, the data, the scales, the scene
    for identifier in (CHART, "identification", "procedure-2dof-thrust", "claim-2dof-thrust-0"):
        assert HOSTILE in page.with_id(identifier).text
    assert page.of_class("notes")[0].text == page.all("caption")[0].text == HOSTILE
    (panel,) = page.data["figures"][CHART]["chart"]
    assert panel["x"] == panel["y"] == panel["curves"][0]["label"] == HOSTILE


def test_numbers_are_those_of_json():
    curve = Curve("a", np.array([1.0, 2.0, np.nan]), np.array([np.inf, 1.23456789e-7, 3.0]))
    assert curve_data(curve) == {"label": "a", "kin": "a", "marked": False,
                                 "x": [1.0, 2.0, None], "y": [None, 1.23457e-07, 3.0]}
    page = page_of([], {}, [outcome(charts=(Chart("4.9", "", (Panel(GAP, THRUST, (curve,)),)),))])
    assert page.data["figures"][CHART]["chart"][0]["curves"] == [curve_data(curve)]


@pytest.mark.usefixtures("slow")
def test_a_long_line_loses_points_but_not_its_shape():
    x = np.linspace(0.0, 60.0, 50001)
    data = curve_data(Curve("a", x, np.sin(x)))
    assert len(data["x"]) <= MOST_POINTS
    np.testing.assert_allclose(np.interp(x, data["x"], data["y"]), np.sin(x), atol=1e-3)
    assert len(curve_data(Curve("a", x, np.sin(x), marked=True))["x"]) == len(x)
    assert len(curve_data(Curve("a", x[::-1], x))["x"]) == len(x)
    assert curve_data(Curve("a", x, np.zeros(len(x))))["y"][-1] == 0.0
    banded = curve_data(Curve("a", x, np.sin(x), margin=0.1 * x))
    assert banded["margin"] == pytest.approx([0.1 * at for at in banded["x"]], rel=1e-5)


def test_a_chart_without_points_is_left_out():
    empty = Chart("4.9", "", (Panel(GAP, THRUST, (Curve("a", [], []),)),))
    assert not [*shown_charts([outcome(charts=(empty, Chart("4.10", "", ())))])]
    (shown,) = shown_charts([outcome(charts=(Chart("4.9", "", (*empty.panels, *chart().panels)),))])
    assert [len(panel["curves"]) for panel in chart_data(shown)["chart"]] == [1, 2]


def test_numbers_stay_with_their_units():
    text = "cogging force, gap 10 to 15 mm or ≤ 2 N, 3 V, 4 kg, 5 ms, 6 µm, 7 %, 8 A, 9 s, of 3 axes, 2 Nodes"
    assert unbroken(text).split(" ")[-5:] == ["of", "3", "axes,", "2", "Nodes"]
    assert unbroken(text).count("\N{NO-BREAK SPACE}") == 10, "and a sign with its number"


def test_a_run_figure_lists_the_claims_of_its_procedure_and_begins_with_the_time_that_counts():
    simulated = recorded(packaged("2dof-identification-rig"))
    settings = simulated.plan.procedure
    assert settings is not None
    page = page_of([simulated], outcomes=[Outcome(settings, (simulated.plan.name,),
                                              (ProcedureValue("position_deviation", 0.02, axis="v"),))])
    shown = page.with_id("figure-4-15").text
    assert "follows the positions" in shown and "reproduced" in shown
    assert "C1 is near" not in shown   # cites a table
    assert page.data["figures"]["figure-4-15"]["until"] == 10.0
