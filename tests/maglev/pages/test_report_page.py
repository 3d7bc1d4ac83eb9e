import re

import numpy as np
import pytest
from packed_series import unpack
from report_runs import (
    Page,
    all_recorded,
    bound,
    failed,
    judged,
    packaged,
    page_of,
    recorded,
    renamed,
    with_columns,
    without_anything,
)

from maglev.pages import plot_data as data_module
from maglev.pages import report_page as page_module
from maglev.pages.figures import MOVING, read_figures, shown_figures
from maglev.pages.plot_data import FEWEST_ROWS, LARGEST_DATA, runs_data
from maglev.pages.report_page import SCRIPTS, report_page, write_report
from maglev.runs.verdicts import VERDICTS, ClaimResult

pytestmark = pytest.mark.usefixtures("slow")

SETPOINTS = packaged("2dof-setpoints")
HOSTILE = '</script><script>alert("1 & 2")</script>'


@pytest.fixture(scope="module")
def page() -> Page:
    """Page of every packaged run, with claims of every verdict on each."""
    results = all_recorded()
    return page_of(results, {result.plan.name: [judged(verdict) for verdict in VERDICTS] for result in results})


def test_nothing_is_loaded(page):
    assert [(link["rel"], (link["href"] or "")[:19]) for link in page.all("link")] == [("icon", "data:image/svg+xml,")]
    assert not {"img", "iframe", "object", "embed", "base"} & {element.tag for element in page.elements}
    assert page.attributes("src") == page.attributes("action") == []
    assert not re.search(r"url\(|@import", "".join(style.text for style in page.all("style")))
    (policy,) = [meta["content"] for meta in page.all("meta") if meta["http-equiv"]]
    assert policy.startswith("default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; ")


def test_every_link_has_its_target_and_every_id_is_unique(page):
    identifiers = page.attributes("id")
    assert len(set(identifiers)) == len(identifiers)
    links = [link["href"] for link in page.all("a")]
    assert len(links) > 200
    assert {link[:1] for link in links} == {"#"}
    assert {link[1:] for link in links} <= set(identifiers)


def test_every_figure_and_run_is_on_the_page(page):
    drawn = page.attributes("data-figure")
    assert {figure.id for figure in read_figures()} <= set(drawn)
    assert list(page.data["figures"]) == drawn
    assert page.data["runs"].keys() == {result.plan.name for result in all_recorded()}
    assert list(page.data["moving"]) == list(MOVING)
    alone = page_of([recorded(packaged("2dof-step-2-linear"))])
    assert list(alone.data["moving"]) == ["2dof-step-2-linear"], "of none of these the first"


def test_runs_open_live_where_the_live_page_lies_beside(tmp_path):
    """Those that it can run as they were run here."""
    results = [recorded(packaged("2dof-setpoints")), recorded(packaged("2dof-identification-rig"))]
    (tmp_path / "live.html").touch()
    write_report(tmp_path / "report.html", results, {})
    write_report(tmp_path / "elsewhere" / "report.html", results, {})
    beside, alone = ((tmp_path / name).read_text() for name in ("report.html", "elsewhere/report.html"))
    assert set(re.findall(r'href="(live\.html[^"]*)"', beside)) == {"live.html#run=2dof-setpoints"}
    assert "live.html" not in alone


def test_text_is_escaped():
    plan = renamed("2dof-setpoints", f"mine {HOSTILE}").model_copy(
        update={"title": HOSTILE, "description": HOSTILE})
    claim = judged("not reproduced", text=HOSTILE, source=HOSTILE, reason=HOSTILE)
    page = page_of([recorded(plan), failed(renamed("3dof-setpoints", "other"), HOSTILE)], {plan.name: [claim]})
    assert len(page.all("script")) == 4 + len(SCRIPTS)   # the index, the data, the scales, the scene
    assert page.of_class("reason")[0].text == HOSTILE
    assert page.data["runs"][plan.name]["title"] == HOSTILE
    assert HOSTILE in page.with_id("run-other").text


def test_the_page_of_nothing_says_so():
    page = page_of([])
    assert "No run was recorded." in page.with_id("figures").text
    assert page.data == {"runs": {}, "figures": {}, "moving": {}}


def test_a_run_without_axes_and_motors_has_no_figure():
    page = page_of([recorded(without_anything("mine"))])
    assert "No figure shows these runs." in page.with_id("figures").text
    assert "mine: " in page.with_id("assumptions").text
    assert page.data["runs"]["mine"]["signals"] == {}


def test_values_that_are_not_finite_are_left_out():
    result = recorded(SETPOINTS)
    position = result.columns["plant.v.position"].copy()
    position[100:200] = np.nan
    position[300] = np.inf
    result = with_columns(result, {**result.columns, "plant.v.position": position,
                                   "plant.motor.i_a": np.full(len(position), np.nan)})
    run = page_of([result]).data["runs"]["2dof-setpoints"]
    time, values = unpack(run)["plant.v.position"]
    assert np.isfinite(values).all()
    assert not ((time > 0.0995) & (time < 0.1995)).any()
    assert "plant.motor.i_a" not in run["signals"]


def test_the_page_has_the_recorded_runs(page):
    result = recorded(packaged("3dof-setpoints"))
    run = page.data["runs"]["3dof-setpoints"]
    for name, (time, values) in unpack(run).items():
        wanted = (result.columns[name] if name in result.columns
                  else result.columns[name.split(" - ")[0]] - result.columns[name.split(" - ")[1]])
        np.testing.assert_allclose(np.interp(result.time, time, values), wanted, rtol=0.0,
                                   atol=1.2 * run["signals"][name]["tolerance"])


def test_written_whole_and_the_same_each_time(tmp_path):
    results = [recorded(SETPOINTS)]
    for path in (tmp_path / "new" / "a.html", tmp_path / "b.html"):
        write_report(path, results, {})
    assert [path.name for path in tmp_path.iterdir() if path.is_file() and path.name != "index.html"] == ["b.html"]
    content = (tmp_path / "b.html").read_bytes()
    assert content == (tmp_path / "new" / "a.html").read_bytes()
    assert len(Page(content.decode()).all("script")) == 4 + len(SCRIPTS)   # the index, the data, the scales, the scene


def test_no_trace_of_an_unfinished_page(tmp_path, monkeypatch):
    path = tmp_path / "report.html"
    path.write_text("before")
    monkeypatch.setattr(page_module, "report_page", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        write_report(path, [], {})
    assert path.read_text() == "before"


def test_the_largest_page_is_below_11_mb():
    results = all_recorded()
    shown = shown_figures(read_figures(), results)
    fewest = runs_data(results, shown)
    signals = sum(len(run["signals"]) for run in fewest.values())
    # Noise cannot be compressed: a row takes 5 bytes (test_series); Base64 writes 4 for 3.
    assert signals * FEWEST_ROWS * 5.02 * 4 / 3 < LARGEST_DATA
    rest = len(report_page(results, {}).encode()) - sum(len(run["data"]) for run in fewest.values())
    claims = 1_000_000
    assert LARGEST_DATA + rest + claims < 11_000_000


def test_noisy_runs_get_fewer_rows(monkeypatch):
    results = [recorded(SETPOINTS, stop_time=5.0, noise=1e-3)]
    shown = shown_figures(read_figures(), results)
    whole = runs_data(results, shown)["2dof-setpoints"]
    monkeypatch.setattr(data_module, "LARGEST_DATA", len(whole["data"]) // 3)
    small = runs_data(results, shown)["2dof-setpoints"]
    assert len(small["data"]) <= len(whole["data"]) // 3
    assert small["signals"].keys() == whole["signals"].keys()


def test_bounds_are_shaded_in_the_panels_that_draw_them():
    claims = [ClaimResult(bound("4.18"), 0.023, "met"),
              ClaimResult(bound("4.18", "plant.v.velocity", metric="largest", unit="m/s", target=[0.1, 0.2]), 0.3,
                          "not met"),
              ClaimResult(bound("4.18", "plant.h.encoder"), 0.023, "met"),   # in no panel of this figure
              ClaimResult(bound("4.19", "plant.v.encoder"), 0.023, "met"),   # of another figure
              judged("reproduced")]
    data = page_of([recorded(SETPOINTS)], {"2dof-setpoints": claims}).data["figures"]
    assert data["figure-4-18"]["bounds"] == [
        {"panel": 0, "low": 0.022, "high": 0.024, "met": True},
        {"panel": 1, "low": 0.1, "high": 0.2, "met": False}, {"panel": 1, "low": -0.2, "high": -0.1, "met": False}]
    assert data["figure-4-20"]["bounds"] == []


def test_a_page_links_to_the_files_of_its_runs_that_lie_beside_it(tmp_path):
    run = recorded(SETPOINTS)
    name = run.plan.name
    (tmp_path / f"{name}.csv").write_text("time\n", encoding="utf-8")
    page = Page(report_page([run], {}, folder=tmp_path))
    assert {link["href"] for link in page.all("a") if "download" in link.attributes} == {f"{name}.csv"}
