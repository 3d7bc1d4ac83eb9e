"""The page of a comparison: the table side by side, and the runs drawn over each other."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path

from maglev.comparison.table import Row, legend, summary
from maglev.experiment.execution import RunResult
from maglev.pages.shell import page, scripts
from maglev.panels import PANELS
from maglev.report.findings import html_table
from maglev.report.page import PLOT_SCRIPTS, json_in_html, plot_height, read
from maglev.report.plots.data import figure_data, runs_data
from maglev.report.plots.figures import EVERY, Figure, with_data
from maglev.report.plots.static import static_picture
from maglev.report.status import run_status
from maglev.report.text import origin

PAGE = Path(__file__).parent / "comparison.html"


def comparison_page(name: str, title: str, runs: Mapping[str, RunResult], rows: Sequence[Row]) -> str:
    """Text of the page, which needs no network."""
    labels = {run.plan.name: label for label, run in runs.items()}
    panels = [f"{kind} {EVERY}" for kind in PANELS]
    figures = list(with_data([Figure(caption=title, runs=labels, panels=[panel]) for panel in panels],
                             list(runs.values())))
    data = {"runs": runs_data(list(runs.values()), figures),
            "figures": {f"figure-{number}": figure_data(shown, {}) for number, shown in enumerate(figures)}}
    return page(
        "compare", f"{escape(name)}: runs side by side", read("style.css"), PAGE.read_text(encoding="utf-8"),
        name=escape(name), subject=escape(title),
        endings="\n".join(f"<li><strong>{escape(label)}</strong>: "
                          f"{escape(', '.join(run_status(run)) or 'the run of the package')}</li>"
                          for label, run in runs.items()),
        origins="\n".join(f"<li><strong>{escape(label)}</strong>: {escape(origin(run.provenance))}</li>"
                          for label, run in runs.items() if run.provenance is not None),
        flown=escape(flown_with(runs.values())),
        legend=escape(legend(runs.values(), "★")),
        summary=row_table(list(runs), summary(rows)),
        steps=row_table(list(runs), [row for row in rows if row.time is not None]),
        figures="\n".join(f"<figure><noscript>{static_picture(shown)}</noscript>"
                          f'<div class="plot" data-figure="figure-{number}" '
                          f'style="min-height:{plot_height(shown)}px"></div></figure>'
                          for number, shown in enumerate(figures)) or "<p>No run was recorded.</p>",
        data=json_in_html(data),
        scripts=scripts(*map(read, PLOT_SCRIPTS)))


def flown_with(runs: Iterable[RunResult]) -> str:
    """Commands and machines that runs were flown with, each once."""
    found = dict.fromkeys(f"Flown by {run.provenance.command}, Python {run.provenance.python}."
                          for run in runs if run.provenance is not None)
    return " ".join(found)


def row_table(labels: Sequence[str], rows: Sequence[Row]) -> str:
    """Table of rows; the best value of a row is marked with a star and in bold."""
    return html_table(("quantity", "of", *labels), (
        (escape(row.name), escape(row.of), *(mark(escape(row.text(label)), label in row.best) for label in labels))
        for row in rows)) if rows else "<p>Nothing was measured.</p>"


def mark(text: str, best: bool) -> str:
    """A value, marked if it is the best of its row."""
    return f'<strong class="best">{text} <span aria-label="best">★</span></strong>' if best else text
