"""Files about runs next to each other: columns of each run, one JSON, one text, a picture and a page."""

import tomllib
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import cache
from html import escape
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.text import Text

from maglev.files.console import ResultTable, heading
from maglev.files.one_writer import NoLock, only_writer
from maglev.files.pictures import write_figure
from maglev.files.whole_file import write_whole
from maglev.pages import shell
from maglev.pages.comparison_table import Row, comparison_verdict, legend, measure_rows, summary
from maglev.pages.figures import EVERY, Figure, controller_of, run_colours, with_data
from maglev.pages.findings import html_table, typeset
from maglev.pages.frequency import frequency_charts, margins_section, spectra
from maglev.pages.picture import overlay
from maglev.pages.plot_data import figure_data, moving, runs_data
from maglev.pages.report_page import (
    PIXELS,
    PLAYER,
    PLOT_SCRIPTS,
    STYLE,
    TOOLS,
    command_line,
    file_links,
    json_in_html,
    plot_height,
    read,
)
from maglev.pages.run_text import as_text, origin
from maglev.runs.execution import RunResult, json_text, run_as_json, write_result
from maglev.runs.measures import measures_of
from maglev.runs.results import ResultFiles, write_csv

LONGEST_WAIT = 60.0   # s, for another comparison that is being written
FOLDER = Path(__file__).with_name("comparison")
BEST = "*"   # behind the best value of a row, where there is no colour

Runs = Mapping[str, RunResult]   # by label, also those that failed

SHOWN = ("error", "position", "commands", "own")   # panels of the page, in this order


@cache
def instructions() -> dict[str, float]:
    """Return the instructions a sample on a Cortex-M7 by the name of the FMU, as measured by `tools/write_costs.py`."""
    text = (FOLDER / "costs.toml").read_text(encoding="utf-8")
    return {name: float(table["mean"]) for name, table in tomllib.loads(text).items()}


def compared_rows(runs: Runs) -> list[Row]:
    """Return the measured values of the completed runs side by side, with the costs of their laws, if known."""
    metrics = {label: run.metrics for label, run in runs.items() if run.metrics is not None}
    rows = measure_rows({label: measures_of(runs[label].plan, measured) for label, measured in metrics.items()})
    costs = {label: instructions()[law] for label in metrics
             if runs[label].provenance is not None and (law := controller_of(runs[label])) in instructions()}
    flaws = {label: run.outcome for label, run in runs.items() if run.outcome != "completed"}
    return [*rows, *([Row("instructions a sample", "its law", None, "", costs, flaws)] if costs else [])]


def write_comparison(folder: Path, name: str, title: str, runs: Runs, *, picture: bool, page: bool) -> list[Path]:
    """Write the files of a comparison into a folder; return the paths.

    `NAME@LABEL.csv` and `NAME@LABEL.json` of each run, then `NAME.compare.json`, `.txt`, and if asked for `.png` and
    `.html`. A run that ended early leaves `NAME@LABEL.partial.csv`, and the files of an earlier one get other names. It
    waits for other processes that write this comparison there; Busy if that takes longer than `LONGEST_WAIT`.
    """
    with ExitStack() as alone:
        with suppress(NoLock):
            alone.enter_context(only_writer(folder / f".{name}.compare.lock", wait=LONGEST_WAIT))
        written = []
        for run in runs.values():
            files = ResultFiles(folder, run.plan.name)
            if run.metrics is None:
                files.set_aside()
                if len(run.time):
                    write_csv(files.file("partial.csv"), run.recording)
                    written.append(files.file("partial.csv"))
                continue
            write_result(files, "csv", run, {}, run.recording)
            written += [files.file("csv"), files.file("json")]
        about = {"json": json_text(comparison_data(name, title, runs)),
                 "txt": as_text(lambda console: show_comparison(console, name, title, runs, every_step=True))}
        for suffix, text in about.items():
            written.append(folder / f"{name}.compare.{suffix}")
            write_whole(written[-1], text)
        if page:
            written.append(folder / f"{name}.compare.html")
            shell.publish(written[-1], comparison_page(name, title, runs, compared_rows(runs), folder))
        recorded = {label: run for label, run in runs.items() if len(run.time)}
        if picture and recorded:
            written.append(folder / f"{name}.compare.png")
            write_figure(written[-1], overlay(f"{name}: {title}", recorded))
    return written


def comparison_data(name: str, title: str, runs: Runs) -> dict[str, Any]:
    """Return a comparison in JSON form, SI: each run, and the rows of the table; null for a time without end."""
    return {"name": name, "title": title, "verdict": comparison_verdict(runs, summary(compared_rows(runs))),
            "runs": {label: run_as_json(run) for label, run in runs.items()},
            "rows": [{"quantity": row.quantity, "of": row.of, "time": row.time, "unit": row.unit,
                      "values": {label: value if value < float("inf") else None for label, value in row.values.items()},
                      "best": list(row.best)} for row in compared_rows(runs)]}


def show_comparison(console: Console, name: str, title: str, runs: Runs, every_step: bool = False) -> None:
    """Print how each run ended, and the table side by side: the worst of all steps, or every step."""
    console.print(heading(name, title))
    rows = compared_rows(runs)
    console.print(Text(comparison_verdict(runs, summary(rows))))
    for label, run in runs.items():
        console.print(Text.assemble((label, "bold"), f": {run.ending}"))
    if not rows:
        return
    shown = rows if every_step else summary(rows)
    leads = ["the next is"] if any(row.best for row in shown) else []
    console.print(ResultTable(legend(runs.values(), BEST), ("quantity", "of", *runs, *leads), (
        [row.name, row.of, *(Text(row.text(label) + BEST, "bold green") if label in row.best else row.text(label)
                             for label in runs), *(row.ahead for _ in leads)]
        for row in shown), left=2, spare=len(leads)))


def comparison_page(name: str, title: str, runs: Mapping[str, RunResult], rows: Sequence[Row],
                    folder: Path | None = None) -> str:
    """Text of the page, which needs no network; it links to files of the runs if they are in its folder."""
    colours, recorded = run_colours(runs), {label: run for label, run in runs.items() if len(run.time)}
    drawn = {run.plan.name: colours[label] for label, run in runs.items()}
    labels = {run.plan.name: label for label, run in runs.items()}
    figures = [shown._replace(colours=drawn) for shown in with_data(
        [Figure(caption=title, runs=labels, panels=[f"{kind} {EVERY}"]) for kind in SHOWN], list(runs.values()))]
    data = {"runs": runs_data(list(runs.values()), figures),
            "figures": {f"figure-{number}": figure_data(shown, {}) for number, shown in enumerate(figures)},
            "moving": {run.plan.name: film for run in [*recorded.values()][:1] if (film := moving(recorded))}}
    margins, sensitivities = margins_section(runs)
    charts = frequency_charts(sensitivities, spectra(recorded), colours)
    data["figures"] |= charts
    said = typeset(comparison_verdict(runs, summary(rows)))
    return shell.page(
        "compare", f"{escape(name)}: runs side by side", said, STYLE,
        shell.read("comparison.html", FOLDER),
        name=escape(name), subject=escape(title), verdict=said,
        origins="\n".join(f"<li><strong>{escape(label)}</strong>: {escape(origin(run.provenance))}"
                          f"{file_links(folder, run.plan.name)}</li>"
                          for label, run in runs.items() if run.provenance is not None),
        made=command_line(runs.values()) + "".join(f"<p>Python {version}.</p>" for version in dict.fromkeys(
            run.provenance.python for run in runs.values() if run.provenance is not None)),
        legend=escape(legend(runs.values(), "★")), moving=PLAYER if data["moving"] else "",
        summary=row_table(list(runs), summary(rows)),
        steps=row_table(list(runs), [row for row in rows if row.time is not None]),
        figures="\n".join(f'<figure><div class="plot" data-figure="figure-{number}" '
                          f'style="min-height:{plot_height(shown)}px"></div></figure>'
                          for number, shown in enumerate(figures)) or "<p>No run was recorded.</p>",
        margins=margins,
        frequency="\n".join(f'<figure><div class="plot" data-figure="{name}" style="min-height:'
                            f'{TOOLS + PIXELS * len(chart["chart"])}px"></div></figure>'
                            for name, chart in charts.items()),
        data=json_in_html(data),
        scripts=shell.scripts(shell.scene(), *map(read, (*PLOT_SCRIPTS, "player.js"))))


def row_table(labels: Sequence[str], rows: Sequence[Row]) -> str:
    """Table of rows; the best value of a row is marked with a star and in bold."""
    leads = ["the next is"] if any(row.best for row in rows) else []
    if not rows:
        return "<p>Nothing was measured.</p>"
    heads = [label + (f" ({flaw})" if (flaw := rows[0].flaws.get(label)) else "") for label in labels]
    return html_table(("quantity", *heads, *leads), (
        (escape(f"{row.quantity} of {row.of}{row.name.removeprefix(row.quantity)}"),
         *(mark(typeset(row.text(label)), label in row.best) for label in labels),
         *(row.ahead.strip("–").replace(" ", "\N{NO-BREAK SPACE}") for _ in leads))
        for row in rows),
        look="cards numbers")


def mark(text: str, best: bool) -> str:
    """A value, marked if it is the best of its row."""
    return f'<strong class="best">{text} <span aria-label="best">★</span></strong>' if best else text
