"""What a check or an update of baselines comes to."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from maglev.baselines.baseline import Baseline
from maglev.baselines.deviation import Deviation, WorstDifference


@dataclass(frozen=True)
class CheckResult:
    """Outcome of one run.

    Attributes
    ----------
    name : str
        Name of the plan.
    status : str
        "deviated" is a difference beyond its tolerance, "error" a run that could not be compared.
    message : str
        One line, without the name.
    deviation : Deviation, optional
        The first, if there is one.
    worst : dict of str to WorstDifference
        Largest difference of each signal; empty after an error.
    elapsed : float
        Wall time, s.
    units : dict of str to str
        Of each signal, empty text where the FMU gives none.
    ends : mapping of str to float
        Every output at the end, for the runs that start from there; empty if the run was not run to its end.
    notes : tuple of str
        As of `Recording`.
    """

    name: str
    status: Literal["passed", "deviated", "error"]
    message: str
    deviation: Deviation | None
    worst: dict[str, WorstDifference]
    elapsed: float
    units: dict[str, str] = field(default_factory=dict)
    ends: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class UpdateResult:
    """Outcome of the update of one baseline.

    Attributes
    ----------
    name : str
        Name of the plan.
    status : str
        "new": there was no baseline; "replaced": the old one could not be read or compared; "error": nothing was
        written.
    message : str
        One line, without the name.
    moved : dict of str to WorstDifference
        Largest change of each signal that the old baseline had too.
    elapsed : float
        Wall time, s.
    ends : mapping of str to float
        Every output at the end; empty after an error.
    notes : tuple of str
        As of `Recording`.
    baseline : Baseline or None
        The new one; None after an error.
    """

    name: str
    status: Literal["new", "unchanged", "updated", "replaced", "error"]
    message: str
    moved: dict[str, WorstDifference]
    elapsed: float
    ends: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    baseline: Baseline | None = None


def describe(result: CheckResult | UpdateResult) -> str:
    """One line about a result, the name of the plan first."""
    return f"{result.name}: {'error: ' if result.status == 'error' else ''}{result.message}"


def exit_code(results: Sequence[CheckResult | UpdateResult]) -> int:
    """0 if all passed, 1 if some deviated, 2 if anything could not be checked, or nothing was."""
    statuses = {result.status for result in results}
    if "error" in statuses or not statuses:
        return 2
    return 1 if "deviated" in statuses else 0
