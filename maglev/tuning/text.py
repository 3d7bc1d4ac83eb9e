"""What a tuning found, for the terminal, and its gains as a file that a scenario extends."""

import numpy as np
from rich.console import Console

from maglev.arrays import Array
from maglev.quantities import metric_text
from maglev.report.plain import result_table
from maglev.studies.columns import EVENTS
from maglev.tuning.planning import Cost
from maglev.tuning.schema import TuneFile
from maglev.tuning.search import SearchResult


def gains_toml(tuning: TuneFile, result: SearchResult) -> str:
    """The parameters that were found, as a file that a scenario extends."""
    lines = [f"# {line}" for line in (tuning.title or tuning.name, f"Found by maglev tune {tuning.name}: "
                                      f"{tuning.population} candidates, {tuning.generations} generations, "
                                      f"{result.flights} runs of {tuning.scenario}.")]
    by_fmu: dict[str, list[str]] = {}
    for name, value in result.parameters.items():
        fmu, _, own = name.partition(".")
        by_fmu.setdefault(fmu, []).append(f'"{own}" = {value!r}')
    for fmu, entries in by_fmu.items():
        lines += ["", f"[fmus.{fmu}.start]", *entries]
    return "\n".join(lines) + "\n"


def show_result(console: Console, tuning: TuneFile, cost: Cost, result: SearchResult) -> None:
    """Print the metrics before and after, on the plants of the search and on fresh ones, and the parameters."""
    console.print(f"[bold]{tuning.name}[/bold]: {tuning.title or tuning.scenario}", highlight=False)
    groups = [(f"searched, {len(result.before)} plants", result.before, result.after)]
    if tuning.fresh:
        groups.append((f"fresh, {len(result.fresh_before)} plants", result.fresh_before, result.fresh_after))
    for title, before, after in groups:
        heads = ("median before", "after", "largest before", "after", "without end before", "after", "less on")
        console.print(result_table(title, ("metric", *heads), (
            row(column.name, before[:, i], after[:, i], column.unit) for i, column in enumerate(cost.columns)
            if column.name not in EVENTS or column.name == "failed")))
        within = (cost.excess(after[None], before) == 0.0).mean()
        console.print(f"{within:.0%} of the plants within all limits", highlight=False)
    console.print(", ".join(f"{name} = {value:g}" for name, value in result.parameters.items()), highlight=False)


def row(name: str, before: Array, after: Array, unit: str) -> list[str]:
    """Row of a metric: name, medians, the largest that have an end, shares without one, and where it became less."""
    cells = [name]
    for summary in (median, largest):
        cells += [metric_text(name, summary(values), unit) for values in (before, after)]
    cells += [f"{np.mean(~np.isfinite(values)):.0%}" for values in (before, after)]
    return [*cells, f"{np.mean(after < before):.0%}"]


def median(values: Array) -> float:
    """Median, of which half of the plants are below; infinite if as many have no end."""
    return float(np.quantile(np.where(np.isnan(values), np.inf, values), 0.5, method="higher"))


def largest(values: Array) -> float:
    return float(np.max(values[np.isfinite(values)], initial=0.0))
