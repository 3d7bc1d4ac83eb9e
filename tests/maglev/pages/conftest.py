"""A report and a live page of packaged runs in a browser without network; skipped without playwright or a Chromium."""

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from live_homes import HOMES
from native_builds import built_once
from report_outcomes import HOSTILE, chart, outcome
from report_runs import all_recorded, failed, judged, packaged, recorded
from report_tab import PHONE, Tab

from maglev.pages.live_page import live_page
from maglev.pages.report_page import write_report
from maglev.pages.what_if import Again
from maglev.runs.execution import RunResult
from maglev.runs.verdicts import VERDICTS
from maglev.scenario.run_plan import Event

# Of one run, SI.
LIMITS = {"plant.v.stop.lower": 0.018, "plant.v.stop.upper": 0.031, "plant.motor.amplifier.peak": 2.5,
          "controller.current_limit": 1.5, "plant.h.stop.stiffness": 1e5}
EVENTS = [Event(name="push", time=0.1, end=0.3), Event(name="other", time=0.4)]

# Runs enough for a figure of every look: a page of all of them takes a browser three times as long, again and again.
SOME = re.compile("2dof-(identification|pid|setpoints|smooth|step|tracking)|3dof-(setpoints|smooth)|5dof-setpoints")


@pytest.fixture(scope="session")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Report of half the packaged runs, one of them failed."""
    return built_once(tmp_path_factory, "report_of_some", lambda folder: write(folder, [
        result for result in all_recorded() if SOME.match(result.plan.name)])) / "report.html"


@pytest.fixture(scope="session")
def whole_report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same of every packaged run."""
    return built_once(tmp_path_factory, "report_of_all", lambda folder: write(folder, all_recorded())) / "report.html"


def write(folder: Path, results: list[RunResult]) -> None:
    results = [result for result in results if result.plan.name != "2dof-step-3-linear"]
    results = [recorded(packaged("2dof-step-4-linear"), stop_contact=0.25)
               if result.plan.name == "2dof-step-4-linear" else result for result in results]
    results = [replace(result, parameters=LIMITS, plan=result.plan.model_copy(update={"events": EVENTS}))
               if result.plan.name == "2dof-setpoints" else result for result in results]
    results.append(failed(packaged("2dof-step-3-linear"), "plant: the step at 2 s failed"))
    judgements = {result.plan.name: [judged(verdict, reason="friction is assumed") for verdict in VERDICTS]
                  for result in results}
    outcomes = [outcome(charts=(chart(), chart("4.10", HOSTILE, panels=2)), notes=(HOSTILE,), claims=())]
    again = Again([recorded(packaged(name)) for name in ("3dof-setpoints", "2dof-step-1-linear")],
                         [outcome(charts=(chart(), chart("4.10", HOSTILE, panels=2)), claims=())])
    judgements["3dof-setpoints"] = [replace(judged("not reproduced", source="Fig. 5.20"), without=judged("reproduced")),
                                    *judgements["3dof-setpoints"]]
    write_report(folder / "report.html", results, judgements, outcomes, again)


@pytest.fixture(scope="module")
def desktop(browser, report) -> Iterator[Tab]:
    tab = Tab(browser, report)
    yield tab
    tab.close()


@pytest.fixture(scope="module")
def phone(browser, report) -> Iterator[Tab]:
    tab = Tab(browser, report, PHONE)
    yield tab
    tab.close()


@pytest.fixture(scope="session")
def page(wasm_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One live page of three stages."""
    path = tmp_path_factory.mktemp("live") / "live.html"
    path.write_text(live_page(wasm_fmus, [packaged(name) for name in HOMES]), encoding="utf-8")
    return path
