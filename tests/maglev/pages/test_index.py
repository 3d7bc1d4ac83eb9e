"""The index of the report in a browser: search, filters, links, and what is drawn and released."""

import pytest
from report_tab import DESKTOP, PHONE, Tab, wait_until

from maglev.runs.verdicts import VERDICTS

ROWS = "table.claims tr[data-verdict]:visible"
FIGURES = "#figures figure:visible"


@pytest.fixture
def tab(desktop):
    """The tab as it was opened: all is shown, from the top on."""
    yield desktop
    desktop.page.select_option("#index-stage", "")
    desktop.page.select_option("#index-verdict", "")
    desktop.page.fill("#index-search", "")
    wait_until(desktop.page, "!document.querySelector('#filter-result').textContent")
    desktop.evaluate("history.replaceState(null, '', location.pathname); scrollTo(0, 0)")


def test_the_filter_shows_one_verdict(tab):
    page = tab.page
    rows = page.locator("table.claims tr[data-verdict]:visible")
    shown = rows.count()
    everything = page.locator("table.claims tr[data-verdict]").count()
    assert shown == page.locator("table.claims tr[data-verdict]:not(.bounds tr)").count() < everything   # folded
    page.select_option("#index-verdict", "not testable")
    assert 0 < rows.count() == everything // len(VERDICTS)
    assert set(rows.evaluate_all("(rows) => rows.map((row) => row.dataset.verdict)")) == {"not testable"}
    # A link to a claim that is hidden shows it.
    page.evaluate("location.hash = 'claim-2dof-setpoints-0'")
    wait_until(page, "!document.querySelector('#index-verdict').value")
    assert rows.count() == shown


def test_the_index_stays_in_view_and_its_links_lead_to_figures(tab):
    link = tab.page.locator("#index-figures a[href='#figure-4-25']")
    link.click()
    wait_until(tab.page, "scrollY > 3000")
    assert tab.page.locator("#index-search").bounding_box()["y"] >= 0.0
    top = tab.page.locator("#figure-4-25").bounding_box()["y"]
    assert -10 < top < DESKTOP["height"] / 2
    wait_until(tab.page, "document.querySelector('#index-figures [aria-current]')")
    names = tab.page.locator("#index-figures a b").all_text_contents()
    assert names == tab.page.locator("#figures figure h3").all_text_contents()


def test_search_finds_figures_by_number_and_by_every_word(tab):
    tab.page.fill("#index-search", "figure 4.27")
    wait_until(tab.page, "document.querySelectorAll('#index-figures li:not([hidden])').length === 1")
    assert tab.page.locator(FIGURES).count() == 1
    assert tab.page.locator("#filter-result").inner_text().endswith(" 1 figures")
    tab.page.fill("#index-search", "friction assumed")
    wait_until(tab.page, "!document.querySelector('#filter-result').textContent.endsWith(' 1 figures')")
    texts = tab.page.locator(ROWS).evaluate_all("""(rows) => rows.map((row) =>
        (row.textContent + row.parentElement.rows[0].textContent).toLowerCase())""")
    assert all("friction" in text and "assumed" in text for text in texts)
    tab.page.fill("#index-search", "no such thing")
    wait_until(tab.page, "document.querySelector('#filter-result').textContent === '0 claims, 0 figures'")


def test_one_stage_alone(tab):
    everything = tab.page.locator(FIGURES).count()
    counts = {}
    stages = [value
              for value in tab.page.locator("#index-stage option").evaluate_all("all => all.map(one => one.value)")
            if value]
    for stage in stages:
        tab.page.select_option("#index-stage", stage)
        counts[stage] = tab.page.locator(FIGURES).count()
        runs = tab.page.locator("table.claims tbody:visible strong").all_text_contents()
        assert runs
        assert not [name for name in runs if not name.startswith(stage)]
    assert sum(counts.values()) == everything
    assert min(counts.values()) > 0


def test_a_verdict_of_the_index_shows_the_claims_and_the_figures_that_have_it(tab):
    tab.page.select_option("#index-verdict", "not met")
    assert set(tab.page.locator(ROWS).evaluate_all("(rows) => rows.map((row) => row.dataset.verdict)")) == {"not met"}
    for figure in tab.page.locator(FIGURES).all():
        assert figure.locator('li[data-verdict="not met"]').count() > 0


def test_on_a_phone_the_index_opens_and_closes(phone):
    index, page = phone.page.locator("#index-details"), phone.page
    assert index.get_attribute("open") is None
    page.evaluate("scrollTo(0, 5000)")
    page.locator("#index summary").tap()
    link = page.locator("#index-figures a[href='#figure-4-18']")
    link.tap()
    wait_until(page, "!document.getElementById('index-details').open")
    wait_until(page, "document.querySelector('[data-figure=\"figure-4-18\"] .line')")
    top = page.locator("#figure-4-18").bounding_box()["y"]
    assert 0 < top < PHONE["height"] / 2


def test_plots_far_from_the_view_are_released(tab):
    tab.evaluate("location.hash = 'figure-4-18'")
    wait_until(tab.page, "document.querySelector('[data-figure=\"figure-4-18\"] .line')")
    assert len(tab.evaluate("Object.keys(maglevReport.plots)")) < 10
    tab.evaluate("location.hash = 'assumptions'")
    wait_until(tab.page, "!document.querySelector('[data-figure=\"figure-4-18\"] .line')")
    tab.evaluate("location.hash = 'figure-4-18'")
    wait_until(tab.page, "document.querySelector('[data-figure=\"figure-4-18\"] .line')")


def test_paper_has_light_colours_and_no_index(tab):
    tab.page.emulate_media(color_scheme="dark")
    tab.page.emulate_media(media="print", color_scheme="dark")
    assert tab.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert not tab.page.locator("#index").is_visible()
    assert not tab.page.locator(".tools").first.is_visible()
    tab.page.emulate_media(media="screen", color_scheme="light")


# What stands on paper: how many figures, and which have not all their panels with lines.
ON_PAPER = """() => addEventListener("beforeprint", () => {
  const figures = [...document.querySelectorAll("#figures figure")];
  window.paper = { figures: figures.length, empty: figures.filter((figure) => {
    const panels = [...figure.querySelectorAll(".panel")];
    return !panels.length || !panels.every((panel) => panel.querySelector(".panel-plot .line"));
  }).map(({ id }) => id) };
})"""


@pytest.mark.parametrize(("which", "least"), [
    ("report", 35), pytest.param("whole_report", 50, marks=pytest.mark.thorough)])
def test_printed_as_it_is_every_figure_is_drawn(browser, request, which, least):
    """By the browser's menu, however few were looked at; what is far is forgotten again."""
    tab = Tab(browser, request.getfixturevalue(which))
    wait_until(tab.page, "Object.keys(maglevReport.ready).length === Object.keys(report.runs).length")
    tab.evaluate(ON_PAPER)
    assert len(tab.page.pdf()) > 300_000
    paper = tab.evaluate("window.paper")
    assert paper["empty"] == [] and paper["figures"] > least
    wait_until(tab.page, "Object.keys(maglevReport.plots).length < 10")
    tab.close()


def test_claims_are_a_table_on_paper(phone):
    """However narrow the paper is."""
    phone.page.emulate_media(media="print")
    try:
        assert phone.evaluate("getComputedStyle(document.querySelector('.claims tr[id] td')).display") == "table-cell"
        assert not phone.page.locator(".what-if").first.is_visible()
    finally:
        phone.page.emulate_media(media="screen")


def test_a_link_into_the_page_lands_where_it_leads(browser, report):
    """Though the moving picture above grows while the page begins; from then on the place is the reader's."""
    tab = Tab(browser, report, fragment="#figure-5-20")
    wait_until(tab.page, "maglevReport.views && document.querySelector('#figure-5-20 .line')")
    top = "document.getElementById('figure-5-20').getBoundingClientRect().top"
    wait_until(tab.page, f"Math.abs({top} - 16) < 60")
    tab.page.mouse.wheel(0, 300)
    wait_until(tab.page, f"{top} < -200")
    tab.context.close()
