"""What a study says: Sobol indices against an analytic function, worst samples, the page."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from report_tab import DESKTOP, PHONE, SHIFTS, Tab, wait_until
from studied_grid import ABOUT, GRID, broken_at, table
from tiny_study import planned, simulate_samples, tiny

from maglev.many.dataset import samples_schema, samples_table
from maglev.many.study_design import unit_samples
from maglev.pages.study_page import design_text, sensitivity, sensitivity_section, study_page
from maglev.pages.study_text import passing_text
from maglev.pages.study_verdict import (
    decisive_metric,
    edges,
    has_influence,
    passing_shares,
    study_verdict,
    telling,
    where,
)
from maglev.pages.varied import Varied, varied_of


def points() -> np.ndarray[Any, Any]:
    vary = [{"set": name, "kind": "uniform", "low": 0, "high": 1} for name in ("plant.a", "plant.b")]
    return unit_samples(tiny(vary=vary, design={"kind": "saltelli", "samples": 1024}))


def test_sobol_indices_of_a_linear_function() -> None:
    """y = 2 a + b: var y = (4 + 1)/12, so that S_a = 0.8 and S_b = 0.2, first order and total."""
    at = points()
    found, notes = sensitivity(table(2 * at[:, 0] + at[:, 1], at), ABOUT)
    assert not notes
    for kind in ("S1", "ST"):
        assert found["overshoot of v"][kind] == pytest.approx(np.array([0.8, 0.2]), abs=0.01)


def test_sobol_indices_of_a_product() -> None:
    """y = (a - 1/2)(b - 1/2) has no first-order effects; each is in all of the variance."""
    at = points()
    found, _ = sensitivity(table((at[:, 0] - 0.5) * (at[:, 1] - 0.5), at), ABOUT)
    assert found["overshoot of v"]["S1"] == pytest.approx(np.zeros(2), abs=0.02)
    assert found["overshoot of v"]["ST"] == pytest.approx(np.ones(2), abs=0.05)


@pytest.mark.parametrize(("about", "failure", "words"), [
    ({"correlated": [["plant.a", "plant.b"]]}, None, "correlated"), ({}, "refused", "need every sample")])
def test_where_there_are_no_indices_it_says_why(about: dict[str, Any], failure: str | None, words: str) -> None:
    at = points()
    found, (note,) = sensitivity(table(at[:, 0], at, failure), {**ABOUT, **about})
    assert not found
    assert words in note


def test_samples_that_never_settle_have_no_indices() -> None:
    at = points()
    values = at[:, 0].copy()
    values[3] = np.inf
    found, (note,) = sensitivity(table(values, at), ABOUT)
    assert not found
    assert note.startswith("None of overshoot of v: not finite")


def test_the_page_names_the_worst_sample_and_its_command(fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus, title="a <b> title",
                    vary=[{"set": "plant.v.mass", "kind": "list", "values": [4.0, 4.35, 5.0]}],
                    limits={"rms error of v": {"max": "1 um"}})
    made = samples_table(study, simulate_samples(study.job, 0, study.values), samples_schema(study))
    text = study_page(made, study.about)
    worst = int(np.argmax(made["rms error of v"].to_numpy()))
    assert f'<th scope="row">{worst}</th><td data-label="why">largest rms error of v' in text
    assert f"maglev run tiny.toml --set plant.v.mass={[4.0, 4.35, 5.0][worst]}" in text
    assert "0 of 3 samples pass</strong>: all fail by" in text and "a &lt;b&gt; title" in text
    found = json.loads(re.search(r'id="data">(.*?)</script>', text).group(1))   # type: ignore[union-attr]
    drawn = {column["name"]: column for column in found["columns"]}
    by = {"mm": 1e3, "µm": 1e6}[drawn["rms error of v"]["unit"]]   # one unit in the whole page
    assert drawn["rms error of v"]["limits"] == {"max": pytest.approx(by * 1e-6)}
    assert drawn["rms error of v"]["values"] == pytest.approx(by * made["rms error of v"].to_numpy(), rel=1e-5)
    assert found["varied"] == 1 and found["passed"] == "000"
    assert found["columns"][found["begin"][0]]["name"] == "rms error of v", "it opens on what fails"
    assert "Sensitivity" not in text and str(tmp_path) not in text
    assert len(text.encode()) < 75_000


def test_the_page_says_from_where_on_it_breaks() -> None:
    made, about = broken_at(GRID)
    assert telling(made, about) == ["plant.a", "plant.b"]
    assert decisive_metric(made, about) == "overshoot of v"
    passed = np.array(made["passed"].to_pylist())
    assert edges(Varied("", "", "kg", GRID[:, 0]), passed) == ("1 to 4 kg", "1 to 2 kg", "3 to 4 kg")
    assert edges(Varied("", "", "mm", 1e3 * GRID[:, 1]), passed) == ("500 to 1500 mm", "nowhere", "nowhere")
    assert "Without influence on passing: plant.b." in where(made, about)
    text = study_verdict(made, about)
    assert "6 of 12 samples pass" in text and "by overshoot of v above its limit" in text


def test_samples_that_fail_have_the_cause_as_reason() -> None:
    made, about = broken_at(GRID)
    failed = [not each for each in made["passed"].to_pylist()]
    for name, column in {"failed": failed, "ending": [
            "failed: touched an end stop on v at 0.100 s" if each else "completed" for each in failed]}.items():
        place = made.schema.get_field_index(name)
        made = made.set_column(place, made.schema.field(place), pa.array(column))
    said = study_verdict(made, {**about, "limits": {"failed": {"max": 0.0}}})
    assert "the others fail by an end stop on v." in said


def test_of_values_at_random_the_share_that_passes_is_told_with_its_uncertainty() -> None:
    """Wilson's interval has a width where all or none pass; what does not decide has no clear influence."""
    draw = np.random.default_rng(1)
    points = draw.uniform(0.0, 1.0, (200, 2))
    made = table(points[:, 0], points)
    made = made.set_column(made.schema.get_field_index("passed"), "passed", pa.array((points[:, 0] < 0.4).tolist()))
    first, second = varied_of(made, ABOUT)
    passed = points[:, 0] < 0.4
    shares = [part.share for part in passing_shares(first, passed)]
    assert shares[:2] == [1.0, 1.0] and shares[3:] == [0.0, 0.0]
    assert sum(part.samples for part in passing_shares(second, passed)) == 200
    assert has_influence(passing_shares(first, passed), 0.05)
    assert not has_influence(passing_shares(second, passed), 0.05)
    assert "Without clear influence on passing: plant.b." in where(made, ABOUT)
    last, z2 = passing_shares(first, passed)[-1], 1.959964 ** 2
    assert (last.low, last.high) == (0.0, pytest.approx(z2 / (40 + z2)))   # of 0 in 40 its closed form


def test_quantities_without_influence_seldom_appear_to_have_one() -> None:
    draw, wrong = np.random.default_rng(2), 0
    for _ in range(200):
        passed = draw.random(60) < 0.7
        wrong += has_influence(passing_shares(Varied("", "", "", draw.random(60)), passed), 0.05)
    assert wrong <= 20   # 10 are expected, with a deviation of 3


def test_percentages_and_factors_are_told_with_the_nominal_value() -> None:
    made = table(GRID[:, 0], np.column_stack([0.8 + 0.1 * GRID[:, 0], GRID[:, 1]]))
    vary = [{**ABOUT["vary"][0], "kind": "percent", "nominal": 4.35, "unit": "kg"}, ABOUT["vary"][1]]
    percent, other = varied_of(made, {**ABOUT, "vary": vary})
    assert (percent.label, percent.unit) == ("plant.a, change from 4.35 kg", "%")
    assert percent.text(percent.values.min(), percent.values.max()) == "-10 to +20 %"
    factor = varied_of(made, {**ABOUT, "vary": [{**vary[0], "kind": "uniform", "mode": "factor"}]})[0]
    assert factor.text(0.9, 1.2) == "0.9 to 1.2 times 4.35 kg"
    said = study_verdict(made, {**ABOUT, "vary": vary}).replace("\N{NO-BREAK SPACE}", " ")
    assert "plant.a changed from 4.35 kg by \N{MINUS SIGN}10 to +20 %" in said
    assert other.label == "plant.b"


@pytest.mark.parametrize(("passing", "words"), [(1, "1 of 1 sample passes"), (0, "0 of 1 sample passes")])
def test_one_sample_reads_right(passing: int, words: str) -> None:
    assert passing_text(passing, 1) == words


def test_a_page_of_one_sample_says_what_it_is() -> None:
    one = GRID[-1:]
    text = study_page(table(one[:, 0], one), {**ABOUT, "design": {"kind": "grid"}})
    assert '<th scope="col">value</th>' in text and "median" not in text and 'id="response"' not in text
    assert "The sample</h2>" in text and "--set plant.a=4.0 --set plant.b=1.5</code>" in text


def test_large_numbers_of_samples_can_be_read() -> None:
    many = np.arange(2400.0).reshape(1200, 2)
    _, about = broken_at(GRID)
    assert "<strong>1,200 of 1,200 samples pass" in study_verdict(table(many[:, 0], many), about)
    drawn = {"kind": "latin hypercube", "samples": 100_000, "seed": 0}
    assert design_text({"design": drawn}) == "design: latin hypercube, 100,000 samples, seed 0"
    assert "None" not in design_text({"design": {"kind": "rows", "samples": None, "seed": 0}})


def test_the_page_begins_with_the_question_and_the_answer_then_the_map() -> None:
    made, about = broken_at(GRID)
    fmu = {"name": "plant", "file": "Plant.fmu", "kind": "native", "guid": "{a-guid}"}
    about["provenance"] = {**about["provenance"], "fmus": [fmu]}
    text = study_page(made, about)
    order = [text.index(each) for each in (
        "Does tiny stay within its limits with plant.a from 1 to 4 and plant.b from 0.5 to 1.5? <strong>6 of 12 samples"
        " pass", "Where it holds, and where it breaks", 'id="response"', ">quantity<", 'id="histograms"',
        "Plant.fmu (native)")]
    assert order == sorted(order) and "a-guid" not in text
    whole = table(GRID[:, 0] / 10.0, GRID)
    passing = study_page(whole, about)
    assert "12 of 12 samples pass" in passing and "breaks" not in passing
    assert "keep the stage in the air with" in study_page(whole, {**about, "limits": {}})


def test_a_study_of_one_quantity_opens_on_a_metric_and_asks_for_no_second(browser, tmp_path: Path) -> None:
    made, about = broken_at(GRID)
    about |= {"limits": {}, "vary": about["vary"][:1], "targets": about["targets"][:1]}
    (tmp_path / "study.html").write_text(study_page(made, about), encoding="utf-8")
    tab = Tab(browser, tmp_path / "study.html")
    shown = tab.evaluate("""["metric", "first", "second"].map((id) => { const select = document.getElementById(id);
        return [select.selectedOptions[0].text, select.checkVisibility()]; })""")
    assert shown == [["overshoot of v", True], ["plant.a", False], ["plant.a", False]]
    assert tab.page.locator("#metric option").first.text_content() == "samples that pass"
    tab.close()


def test_bars_add_up_to_the_samples_and_stop_at_what_is_known(browser, tmp_path: Path) -> None:
    made, about = broken_at(GRID)
    values = [*made["overshoot of v"].to_pylist()[:-1], float("inf")]
    made = made.set_column(made.schema.get_field_index("overshoot of v"), made.schema.field("overshoot of v"), [values])
    (tmp_path / "study.html").write_text(study_page(made, about), encoding="utf-8")
    tab = Tab(browser, tmp_path / "study.html")
    bars = [(int(count), beyond, float(low), float(high)) for beyond, count, low, high in tab.evaluate("""
        [...document.querySelectorAll(".bars .bar")].map((bar) => [bar.classList.contains("beyond"),
            ...bar.textContent.match(/^([0-9]+) from ([0-9.]+).* to ([0-9.]+)/).slice(1)])""")]
    assert sum(count for count, *_ in bars) == 11
    limit = tab.evaluate("columns.find(({ name }) => name === 'overshoot of v').limits.max")
    assert all(high > limit if beyond else low <= limit for _, beyond, low, high in bars)
    assert [sum(count for count, each, *_ in bars if each is beyond) for beyond in (False, True)] == [6, 5]
    assert tab.page.locator(".bars .limit").count() == 1
    assert "; 1 without" in (tab.page.locator(".bars").get_attribute("aria-label") or "")
    tab.close()


def test_a_drag_over_a_plot_keeps_its_samples_in_all(browser, tmp_path: Path) -> None:
    """A histogram, the plot of two quantities, the lines and the map; a click tells of a sample, to all its bits."""
    draw = np.random.default_rng(4)
    points = draw.uniform(0.0, 1.0, (3000, 2))
    made, about = broken_at(points)
    about["design"] = {"kind": "sobol", "samples": 3000, "seed": 4}
    (tmp_path / "study.html").write_text(study_page(made, about), encoding="utf-8")
    tab = Tab(browser, tmp_path / "study.html")
    count = """[...document.querySelectorAll("{}")].reduce((sum, {{ textContent }}) =>
        sum + Number(/{}/.exec(textContent)[1]), 0)"""
    bars, cells = count.format(".bars .bar", r"(\d+) from"), count.format("#response .cell", r"of (\d+) fail")
    assert tab.page.locator("#response :is(.cell, circle)").count() == 400, "cells of both columns, no marks"
    assert tab.evaluate(bars) == tab.evaluate(cells) == 3000
    tab.page.locator("#response svg").scroll_into_view_if_needed()
    box = tab.page.locator("#response .outline").bounding_box()
    assert box is not None
    tab.page.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + 1)
    tab.page.mouse.down()
    tab.page.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + box["height"] - 1, steps=3)
    tab.page.mouse.up()
    expected = np.sum((points[:, 0] > 0.25) & (points[:, 0] < 0.75))
    wait_until(tab.page, f"Math.abs({bars} - {expected}) < 20")
    assert tab.evaluate(bars) == tab.evaluate(cells) == 3000 - tab.page.locator("#parallel .out").count()
    tab.page.click("#keep-all")
    wait_until(tab.page, f"{bars} === 3000")
    tab.page.locator("#response .cell").first.click()
    sample = int(re.findall(r"Sample (\d+)", tab.page.inner_text("#told"))[0])
    assert tab.page.inner_text("#card code").split("plant.")[1:] == [
        f"{name}={float(value)!r}{end}" for name, value, end in zip("ab", points[sample], (" --set ", ""), strict=True)]
    tab.close()


def test_indices_are_numbers_over_bars_as_long() -> None:
    section = sensitivity_section(table(2 * points()[:, 0] + points()[:, 1], points()), ABOUT)
    shares = re.findall(r'--share: (\d+)%">(\S+) ±', section)
    assert [int(share) / 100 for share, _ in shares] == pytest.approx([0.8, 0.8, 0.2, 0.2], abs=0.02)
    assert all(abs(float(number) - int(share) / 100) < 0.006 for share, number in shares)


@pytest.mark.parametrize(("viewport", "scheme"), [(DESKTOP, "light"), (PHONE, "dark")])
def test_the_page_in_a_browser(browser, tmp_path: Path, viewport, scheme) -> None:
    made, about = broken_at(GRID)
    (tmp_path / "study.html").write_text(study_page(made, about), encoding="utf-8")
    tab = Tab(browser, tmp_path / "study.html", viewport)
    tab.page.emulate_media(color_scheme=scheme)
    seen = tab.evaluate("""() => {
        const picture = document.querySelector("#response svg"), all = (query) => [...picture.querySelectorAll(query)];
        const texts = all("text").map((text) => text.getBoundingClientRect());
        const { left, right } = picture.getBoundingClientRect();
        return { metric: document.getElementById("metric").selectedOptions[0].text, cells: all(".cell").length,
          fails: all(".fails").length - 1, ticks: all("text").map((text) => text.textContent),
          cut: texts.filter((box) => box.left < left - 1 || box.right > right + 1).length,
          covered: texts.filter((a, i) => texts.some((b, k) => k < i && a.left < b.right && b.left < a.right
            && a.top + 3 < b.bottom && b.top + 3 < a.bottom)).length,
          wide: document.documentElement.scrollWidth, first: picture.getBoundingClientRect().top };
    }""")
    assert (seen["metric"], seen["cells"], seen["fails"]) == ("overshoot of v", 12, 6)
    assert {"1", "2", "3", "4", "0.5", "0.7", "1.5"} <= {*seen["ticks"]}, "ticks are values that were simulated"
    assert (seen["cut"], seen["covered"]) == (0, 0)
    assert seen["wide"] == viewport["width"] and seen["first"] < viewport["height"]
    assert tab.evaluate("[...document.querySelectorAll('.wide:not(:has(#parallel))')]"
                        ".filter(({ scrollWidth, clientWidth }) => scrollWidth > clientWidth).length") == 0
    assert sum(share for share, *_ in tab.evaluate(SHIFTS)) < 0.05
    tab.page.select_option("#second", "0")   # over one quantity alone: points, and the limit
    assert tab.page.locator("#response circle").count() == tab.page.locator("#response path.fails").count() - 1 == 6
    assert tab.page.locator("#response .limit").count() == 1
    tab.page.click("text=Ranges as numbers")
    tab.page.locator("#ranges input").nth(1).fill("2.5")
    tab.page.keyboard.press("Tab")
    assert (tab.page.locator("#kept").text_content() or "").startswith("6 of 12 samples, 6 pass: 0, 1, 2")
    tab.close()
