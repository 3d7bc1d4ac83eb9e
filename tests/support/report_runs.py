"""Results of runs that nobody simulated, and what a parser finds in the report of them."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from html.parser import HTMLParser
from typing import Any

import numpy as np

from maglev.cosim.master import Recording
from maglev.pages.report_page import report_page
from maglev.pages.what_if import NOTHING, Again
from maglev.runs.execution import RunResult
from maglev.runs.metrics import Metrics
from maglev.runs.procedure_outcome import Outcome
from maglev.runs.procedures import judge_procedure
from maglev.runs.verdicts import MET_OR_NOT, ClaimResult, Judgements, Verdict
from maglev.scenario.claims import RunClaim
from maglev.scenario.layers import packaged_runs
from maglev.scenario.loading import load_plans
from maglev.scenario.procedure import ProcedureSettings
from maglev.scenario.run_plan import RunPlan

STEP = 1e-3   # s
SPEED = 0.01  # m/s, of every axis; the reference is 1 mm ahead

MEASURED = Metrics(steps=(), tracking=(), motors=(), end_errors={}, stop_contact=None, tripped=None, failed=False)


def recorded(plan: RunPlan, stop_time: float = 0.5, noise: float = 0.0, **metrics: Any) -> RunResult:
    """A completed run: all axes move at SPEED from 20 mm on, currents are sinusoids with an amplitude of 1 A."""
    time = np.arange(round(stop_time / STEP) + 1, dtype=float) * STEP
    random = np.random.default_rng(1)
    columns = {}
    for axis in plan.axes.values():
        columns[axis.position] = 0.02 + SPEED * time + noise * random.standard_normal(len(time))
        columns[axis.reference] = 0.021 + SPEED * time
        columns[axis.position.rpartition(".")[0] + ".velocity"] = np.full(len(time), SPEED)
    for motor in plan.motors.values():
        for k, name in enumerate([*motor.commands, *motor.currents]):
            columns[name] = np.sin(2.0 * np.pi * (time + k / 3.0)) + noise * random.standard_normal(len(time))
    return RunResult(plan, Recording(time, columns), replace(MEASURED, **metrics))


def with_columns(result: RunResult, columns: Mapping[str, np.ndarray], **others: Any) -> RunResult:
    """The same run with other columns."""
    return replace(result, recording=Recording(result.time, columns), **others)


def failed(plan: RunPlan, message: str) -> RunResult:
    """A run that did not complete."""
    return RunResult(plan, failure=message)


@cache
def packaged(name: str) -> RunPlan:
    """Scenario of a packaged run, in which nothing is changed: all of them take seconds to read."""
    (plan,) = load_plans(name)
    return plan


def renamed(name: str, new: str) -> RunPlan:
    """Scenario of a packaged run under another name."""
    return packaged(name).model_copy(update={"name": new})


def of_procedure(name: str, new: str, **changes: Any) -> RunPlan:
    """Scenario of a packaged run under another name, as one of a procedure."""
    settings = ProcedureSettings(kind="parabolas", name="2dof-thrust", title="Thrust by parabolas")
    return renamed(name, new).model_copy(update={"procedure": settings, **changes})


def without_anything(name: str) -> RunPlan:
    """Scenario of a run without axes, motors or claims."""
    return renamed("2dof-setpoints", name).model_copy(update={"axes": {}, "motors": {}, "claims": []})


def all_recorded() -> list[RunResult]:
    """Every packaged run that a figure shows: not the many of a procedure, and none for the check alone."""
    return [recorded(plan) for plan in map(packaged, packaged_runs())
            if (plan.procedure is None or plan.figures) and not plan.check_only]


def judged(verdict: Verdict, text: str = "The overshoot is below 30 %", source: str = "p. 53, Fig. 4.18",
           reason: str | None = None) -> ClaimResult:
    """A claim with a verdict."""
    if verdict == "not testable":
        return ClaimResult(RunClaim(text=text, source=source, not_testable=reason or "no data"), None, verdict)
    if verdict in MET_OR_NOT:
        return ClaimResult(bound(), 0.0225, verdict)
    claim = RunClaim(text=text, source=source, metric="overshoot", relation="<", target=0.3, reason=reason)
    return ClaimResult(claim, None if verdict == "not run" else 0.25, verdict)


def bound(figure: str = "4.18", column: str = "plant.v.encoder", **table: Any) -> RunClaim:
    """A bound by the axis of a figure."""
    return RunClaim.model_validate({"figure": figure, "metric": "highest", "column": column, "unit": "mm",
                                    "target": [22, 24], **table})


@dataclass
class Element:
    """An element: its tag, attributes, and the text in it."""

    tag: str
    attributes: dict[str, str | None]
    text: str = ""

    def __getitem__(self, name: str) -> str | None:
        return self.attributes.get(name)


@dataclass
class Page(HTMLParser):
    """A parsed page."""

    source: str
    elements: list[Element] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()
        self.open: list[Element] = []
        self.feed(self.source)
        self.close()
        assert not self.open, f"not closed: {self.open}"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append(Element(tag, dict(attrs)))
        if tag not in ("meta", "link", "input"):
            self.open.append(self.elements[-1])

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop().tag == tag

    def handle_data(self, data: str) -> None:
        for element in self.open:
            element.text += data

    def all(self, tag: str) -> list[Element]:
        """Elements with a tag."""
        return [element for element in self.elements if element.tag == tag]

    def with_id(self, identifier: str) -> Element:
        """The element with an id."""
        (found,) = [element for element in self.elements if element["id"] == identifier]
        return found

    def of_class(self, name: str) -> list[Element]:
        """Elements of a class."""
        return [element for element in self.elements if name in (element["class"] or "").split()]

    def attributes(self, name: str) -> list[str]:
        """Values of an attribute of all elements that have it."""
        return [element[name] or "" for element in self.elements if name in element.attributes]

    @property
    def data(self) -> Any:
        """What the page's scripts read."""
        return json.loads(self.with_id("data").text)


def page_of(results: Sequence[RunResult], judgements: Judgements | None = None, outcomes: Sequence[Outcome] = (),
            frictionless: Again = NOTHING) -> Page:
    """Page of results; the claims of the outcomes are judged."""
    procedures = {outcome.settings.name: judge_procedure(outcome) for outcome in outcomes}
    return Page(report_page(results, {**(judgements or {}), **procedures}, outcomes, frictionless=frictionless))
