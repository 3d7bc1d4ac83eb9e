"""Outcome of a check or an update of baselines, in words and as JUnit XML, which CI servers show."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

from maglev.files.whole_file import whole_file
from maglev.fmi.escapes import xml_text
from maglev.runs.baseline_file import Baseline
from maglev.runs.deviation import Deviation, WorstDifference

ELEMENTS = {"deviated": "failure", "error": "error"}


@dataclass(frozen=True)
class CheckResult:
    """Outcome of one run; "deviated" is a difference beyond its tolerance, "error" a run that could not be compared."""

    name: str                                                  # of the plan
    status: Literal["passed", "deviated", "error"]
    message: str                                               # one line, without the name
    deviation: Deviation | None                                # the first, if there is one
    worst: dict[str, WorstDifference]                          # largest difference of each signal; empty after an error
    elapsed: float                                             # wall time, s
    units: dict[str, str] = field(default_factory=dict)        # of each signal, empty text where the FMU gives none
    ends: Mapping[str, float] = field(default_factory=dict)    # every output at the end; empty if it ended early
    notes: tuple[str, ...] = ()                                # as of `Recording`

    def __repr__(self) -> str:
        return f"<CheckResult {self.name}: {self.message}>"


@dataclass(frozen=True)
class UpdateResult:
    """Outcome of the update of one baseline.

    "new": there was none; "replaced": the old one could not be read or compared; "error": nothing was written.
    """

    name: str                                                  # of the plan
    status: Literal["new", "unchanged", "updated", "replaced", "error"]
    message: str                                               # one line, without the name
    moved: dict[str, WorstDifference]                          # largest change of each signal that both baselines have
    elapsed: float                                             # wall time, s
    ends: Mapping[str, float] = field(default_factory=dict)    # every output at the end; empty after an error
    notes: tuple[str, ...] = ()                                # as of `Recording`
    baseline: Baseline | None = None                           # the new one; None after an error

    def __repr__(self) -> str:
        return f"<UpdateResult {self.name}: {self.message}>"


def describe(result: CheckResult | UpdateResult) -> str:
    """Return one line about a result, the name of the plan first."""
    return f"{result.name}: {'error: ' if result.status == 'error' else ''}{result.message}"


def exit_code(results: Sequence[CheckResult | UpdateResult]) -> int:
    """Return 0 if all passed, 1 if some deviated, 2 if anything could not be checked, or nothing was."""
    statuses = {result.status for result in results}
    if "error" in statuses or not statuses:
        return 2
    return 1 if "deviated" in statuses else 0


def write_junit(path: Path, results: Sequence[CheckResult]) -> None:
    """Write a test case for each run: a deviation is a failure, and a run that could not be checked an error."""
    statuses = [result.status for result in results]
    suite = ElementTree.Element("testsuite", {
        "name": "maglev check", "tests": str(len(results)), "failures": str(statuses.count("deviated")),
        "errors": str(statuses.count("error")), "time": f"{sum(result.elapsed for result in results):.3f}"})
    for result in results:
        case = ElementTree.SubElement(suite, "testcase", {
            "classname": "maglev.check", "name": xml_text(result.name), "time": f"{result.elapsed:.3f}"})
        if result.status in ELEMENTS:
            message = xml_text(result.message)
            reason = ElementTree.SubElement(case, ELEMENTS[result.status], {"message": message, "type": result.status})
            reason.text = message
        if result.notes:
            ElementTree.SubElement(case, "system-out").text = xml_text("\n".join(result.notes))
    ElementTree.indent(suite)
    with whole_file(path) as unfinished:
        ElementTree.ElementTree(suite).write(unfinished, encoding="utf-8", xml_declaration=True)
