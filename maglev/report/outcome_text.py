"""What a procedure found, as text and as CSV."""

import csv
from collections.abc import Iterable, Sequence
from io import StringIO
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from maglev.judging.verdicts import ClaimResult, Judgements
from maglev.procedures.outcome import Chart, Outcome, ValueTable
from maglev.report.text import as_text, claim_tables, heading
from maglev_files.whole_file import write_whole

COLUMNS = ("figure", "panel", "curve", "x", "y", "margin")


def show_outcome(console: Console, outcome: Outcome, claims: Sequence[ClaimResult]) -> None:
    """Print what a procedure found, and the claims about it with their verdicts."""
    console.print(heading(outcome.settings.name, outcome.settings.title))
    for table in outcome.tables:
        console.print(value_table(table))
    for note in outcome.notes:
        console.print(Text(f"note: {note}"))
    for table_of_claims in claim_tables(claims):
        console.print(table_of_claims)


def value_table(table: ValueTable) -> Table:
    printed = Table(title=Text(table.title, style="table.title"))
    for name in table.header:
        printed.add_column(Text(name))
    for row in table.rows:
        printed.add_row(*map(Text, row))
    return printed


def outcome_text(outcome: Outcome, claims: Sequence[ClaimResult]) -> str:
    """What `show_outcome` prints, as text."""
    return as_text(lambda console: show_outcome(console, outcome, claims))


def write_outcomes(outcomes: Iterable[Outcome], verdicts: Judgements, out: Path) -> list[Path]:
    """Write `NAME.txt` of each outcome, and `NAME.curves.csv` if it has charts; returns the files."""
    files = []
    for outcome in outcomes:
        name = outcome.settings.name
        files.append(out / f"{name}.txt")
        write_whole(files[-1], outcome_text(outcome, verdicts[name]))
        if outcome.charts:
            files.append(out / f"{name}.curves.csv")
            write_whole(files[-1], curves_csv(outcome.charts))
    return files


def curves_csv(charts: Iterable[Chart]) -> str:
    """Points of all curves, a row for each; numbers such that reading them gives the same bits.

    A figure without a number goes by its caption. A panel is named by its place in the figure, from 1, and by what it
    has over what. `margin` is the half width of the band about a curve, empty where it has none.
    """
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for chart in charts:
        for k, panel in enumerate(chart.panels, start=1):
            name = f"{k}: {panel.y_title} over {panel.x_title}"
            for curve in panel.curves:
                place = chart.number or chart.caption, name, curve.label
                margins = [""] * len(curve.x) if curve.margin is None else [repr(float(each)) for each in curve.margin]
                writer.writerows((*place, repr(float(x)), repr(float(y)), margin)
                                 for x, y, margin in zip(curve.x, curve.y, margins, strict=True))
    return text.getvalue()
