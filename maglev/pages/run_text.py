"""Metrics, verdicts and outcomes of procedures as tables for the terminal, the text report, Markdown and CSV."""

import csv
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from io import StringIO
from pathlib import Path

from rich.console import Console
from rich.text import Text

from maglev.files.console import ResultTable, heading, plain_console
from maglev.files.errors import visible
from maglev.files.marked import markdown_table
from maglev.files.whole_file import write_whole
from maglev.fmi.escapes import csv_text
from maglev.pages.status import is_listed, modification, own_and_packaged, run_status
from maglev.runs.endings import COMPLETED, ending
from maglev.runs.execution import RunResult
from maglev.runs.measures import Measure, measures_of
from maglev.runs.metrics import Metrics, StepResponse
from maglev.runs.procedure_outcome import Chart, Outcome
from maglev.runs.provenance import Provenance
from maglev.runs.verdicts import (
    MISSED,
    VERDICTS,
    ClaimResult,
    Judgements,
    Verdict,
    bound_claims,
    bounds_in_words,
    bounds_met,
    by_kind,
    count_verdicts,
    met_of,
    sentences,
    specification,
    those_that_count,
)
from maglev.scenario.claims import CLAIM_KINDS
from maglev.scenario.quantities import PRINTED_UNITS, printed
from maglev.scenario.run_plan import RunPlan

REPORT_WIDTH = 80   # characters
MOST_SHOWN = 3      # procedures whose findings are printed; there are files of all
PREFORMATTED = '<pre style="line-height: 1.2">{code}</pre>'

TAG = re.compile(r"<(?=[A-Za-z/!?])")   # where Markdown begins to take text for HTML

Starts = Mapping[tuple[str, float | None], Sequence[str]]   # first cells of a row, by axis or motor and time

COLOURS: dict[Verdict, str] = {"reproduced": "green", "within 10 %": "yellow", "no difference": "red",
                               "not reproduced": "red", "not testable": "dim", "not run": "magenta",
                               "modified run": "cyan", "met": "green", "not met": "red"}

CURVE_COLUMNS = ("figure", "panel", "curve", "x", "y", "margin")


def show(console: Console, result: RunResult, verdicts: Sequence[ClaimResult], briefly: bool = False) -> None:
    """Print the metrics of a run, the claims about it with their verdicts, and how it ended.

    `briefly` shortens the claims. It leaves out axis-range checks, whose number is in the last line, and the reason of
    a run that did not complete, which is printed elsewhere.
    """
    plan = result.plan
    console.print(heading(plan.name, plan.title))
    if result.metrics is None:
        console.print(Text(", ".join(run_status(result, reason=not briefly))))
        return
    if result.provenance is not None:
        console.print(Text(origin(result.provenance), style="dim"))
    claims = [judged for judged in verdicts if judged.claim.figure is None] if briefly else verdicts
    tables = [(short_claims if briefly else claim_table)(title, of_kind) for title, of_kind in titled_claims(claims)]
    for table in (*metric_tables(plan, result.metrics), *tables):
        console.print(table)
    if briefly and (footnote := fitted_to(claims)):
        console.print(Text(footnote))
    console.print("; ".join([outcome_line(result, result.metrics), *sums(verdicts)]))


class Printable:
    """A result that prints as the tables of the terminal, also in a notebook."""

    __slots__ = ()

    def show(self, console: Console) -> None:
        """Print the tables on a console of rich."""
        raise NotImplementedError

    def __str__(self) -> str:
        return as_text(self.show)

    def _repr_html_(self) -> str:
        console = plain_console(file=StringIO(), record=True, width=REPORT_WIDTH)
        self.show(console)
        return console.export_html(inline_styles=True, code_format=PREFORMATTED)


class Verdicts(Printable, tuple[ClaimResult, ...]):
    """Claims with their verdicts."""

    __slots__ = ()

    def show(self, console: Console) -> None:
        """Print the tables."""
        tables = claim_tables(self)
        console.print(*tables, *([] if tables else ["no claims"]), sep="\n")

    __repr__ = Printable.__str__


def show_results(console: Console, asked: Sequence[str], results: Sequence[RunResult], verdicts: Judgements,
                 outcomes: Sequence[Outcome]) -> None:
    """Print the text of the only requested run, or a table of all, and the outcomes of procedures."""
    if len(asked) == 1:
        show(console, results[0], verdicts[results[0].plan.name], briefly=True)
    else:
        console.print(*study_tables(results, verdicts, outcomes), sep="\n")
    for outcome in outcomes if len(outcomes) <= MOST_SHOWN else ():
        show_outcome(console, outcome, verdicts[outcome.settings.name])


def run_text(result: RunResult, verdicts: Sequence[ClaimResult]) -> str:
    """Return the output of `show` as text."""
    return as_text(lambda console: show(console, result, verdicts))


def as_text(show: Callable[[Console], None]) -> str:
    text = StringIO()
    show(plain_console(file=text, width=REPORT_WIDTH, force_terminal=False))   # which FORCE_COLOR would make it
    return text.getvalue()


def origin(provenance: Provenance) -> str:
    """Return version, kinds of the FMUs and the differences from the plan, in a line."""
    commit = f" ({provenance.commit})" if provenance.commit else ""
    kinds = ", ".join(f"{fmu.name}: {fmu.kind} {fmu.model}" for fmu in provenance.fmus)
    modified = f"; modified: {', '.join(provenance.differences)}" if provenance.modified else ""
    return f"Maglev FMUs {provenance.version}{commit}; {kinds}{modified}"


def metric_tables(plan: RunPlan, metrics: Metrics) -> list[ResultTable]:
    """Tables of steps, events, errors and currents, as far as the run has them; lengths and angles apart."""
    groups: dict[tuple[str, str], list[Measure]] = {}
    for measure in measures_of(plan, metrics):
        if measure.of:
            unit = plan.axes[measure.of].unit if measure.of in plan.axes else ""
            kind = ("event" if unit else "effort") if measure.event else "step" if measure.time is not None else (
                "axis" if unit else "motor")
            groups.setdefault((kind, unit), []).append(measure)
    steps: Starts = {(step.axis, step.time): (window_text(step), step.axis, *(
        printed(value, "", PRINTED_UNITS[plan.axes[step.axis].unit]) for value in (step.start, step.target)))
        for step in metrics.steps}
    after: Starts = {(of, event.time): (f"{event.name}, {event.time:g} to {event.end:g} s", of)
                     for event in metrics.events for of in (*plan.axes, *plan.motors)}
    begin = plan.metrics.tracking_from
    heads = {"step": ("Steps: settling time is the time after which the error stays within a band",
                      ("window", "axis", "from", "to")),
             "event": ("Events: recovery time is the time after which the error stays within a band",
                       ("after", "axis")),
             "axis": ("Errors over the run" + ("" if begin is None else f"; tracking errors from t = {begin:g} s on"),
                      ("axis",)),
             "motor": ("Currents: absolute values", ("motor",)),
             "effort": ("Currents after events", ("after", "motor"))}
    return [measure_table(*heads[kind], of_kind, after if kind in ("event", "effort") else steps)
            for (kind, _), of_kind in sorted(groups.items(), key=lambda group: list(heads).index(group[0][0]))]


def window_text(step: StepResponse) -> str:
    """Return the window of a step, and the event that cut it short, such as "1 to 6 s, until push"."""
    return f"{step.time:g} to {step.end:g} s" + (f", until {step.cut_by}" if step.cut_by else "")


def measure_table(title: str, heads: Sequence[str], shown: Sequence[Measure], starts: Starts) -> ResultTable:
    """Table with a row for each axis, motor, step or event, whose first cells may be in `starts`, and its metrics."""
    columns = dict.fromkeys(measure.quantity for measure in shown)
    rows: dict[tuple[str, float | None], dict[str, str]] = {}
    for measure in shown:
        rows.setdefault((measure.of, measure.time), {})[measure.quantity] = measure.text
    return ResultTable(title, (*heads, *columns), (
        [*starts.get(place, place[:1]), *(cells.get(name, "–") for name in columns)]
        for place, cells in sorted(rows.items(), key=lambda row: row[0][1] or 0.0)), left=min(len(heads), 2))


def claim_tables(results: Sequence[ClaimResult]) -> list[ResultTable]:
    """Tables of a user's own claims, of the thesis's in words and of the bounds of its figures."""
    return [claim_table(title, claims) for title, claims in titled_claims(results)]


def titled_claims(results: Sequence[ClaimResult]) -> list[tuple[str, Sequence[ClaimResult]]]:
    """A user's own claims, the thesis's in words and the bounds of its figures, with titles, without empty ones."""
    return [(f"{title}: {met_of(claims)} met" if met_of(claims) else title, claims) for title, claims in (
        ("Your specification", specification(results)), ("Claims of the thesis", sentences(results)),
        ("Axis-range checks", bound_claims(results))) if claims]


def short_claims(title: str, results: Sequence[ClaimResult]) -> ResultTable:
    """Table of claims with a star at those that a parameter was fitted to; the criterion only where it was missed."""
    return ResultTable(title, ("verdict", "claim", "measured"), (
        [Text(judged.verdict, COLOURS[judged.verdict], no_wrap=True),
         "; ".join(filter(None, (judged.claim.text, f"expected {judged.claim.criterion}" if judged.verdict in MISSED
                                and judged.claim.criterion else "", judged.explanation))),
         judged.measured_text + (" *" if judged.claim.chose else "")] for judged in results), left=3)


def fitted_to(results: Sequence[ClaimResult]) -> str:
    """Footnote of the stars: the parameters that were fitted to claims; empty if there are none."""
    chosen = dict.fromkeys(judged.claim.chose for judged in results if judged.claim.chose)
    return f"* not independent: the claim was used to choose {'; '.join(chosen)}" if chosen else ""


def claim_table(title: str, results: Sequence[ClaimResult]) -> ResultTable:
    return ResultTable(title, ("verdict", "claim"), (
        [Text(judged.verdict, COLOURS[judged.verdict], no_wrap=True),
         f"{judged.claim.text} ({judged.claim.cited}): " + "; ".join(filter(None, (", ".join(
             f"{word} {detail}" for word, detail in (("expected", judged.claim.criterion),
                                                    ("measured", judged.measured_text)) if detail), judged.note)))]
        for judged in results), left=2)


def study_tables(results: Sequence[RunResult], verdicts: Judgements, outcomes: Sequence[Outcome] = ()
                 ) -> Iterator[ResultTable]:
    """Tables of many runs and of procedures: a user's own first, then those of the package."""
    own, packaged = own_and_packaged(results, outcomes)
    if own:
        rows = [*((run.plan.name, short_outcome(run)) for run in own.results),
                *((outcome.settings.name, counted(outcome.values, "value")) for outcome in own.outcomes)]
        yield ResultTable("Your runs", ("run", "outcome", "met"), (
            [name, said, met_of(specification(verdicts[name])) or "no claims"] for name, said in rows), left=2)
    if packaged or not own:
        yield study_table(packaged.results, verdicts, packaged.outcomes)


def study_table(results: Sequence[RunResult], verdicts: Judgements, outcomes: Sequence[Outcome] = ()) -> ResultTable:
    """Table of many runs and of procedures: how each ended, and how many of its claims have which verdict."""
    claims = those_that_count(judged for _, judged in claims_in_order(results, verdicts, outcomes))
    totals = count_verdicts(sentences(claims))
    shown = [verdict for verdict in VERDICTS if totals[verdict]]
    procedures = counted(outcomes, "procedure") if outcomes else ""
    return ResultTable("Verdicts on the claims", ("run", "outcome", *shown, "axis-range checks met"), [
        *([run.plan.name, short_outcome(run), *counted_cells(verdicts[run.plan.name], shown)]
          for run in results if is_listed(run, verdicts)), None,
        *([outcome.settings.name, counted(outcome.values, "value"),
           *counted_cells(verdicts[outcome.settings.name], shown)] for outcome in outcomes), None,
        *([name, counted(of_kind, "claim"), *counted_cells(of_kind, shown)]
          for name, of_kind in by_kind(claims).items()), None,
        [f"{len(results)} runs", procedures, *(str(totals[verdict]) for verdict in shown), bounds_met(claims)]], left=2)


def claims_in_order(results: Sequence[RunResult], verdicts: Judgements,
                    outcomes: Sequence[Outcome]) -> list[tuple[str, ClaimResult]]:
    """Return all claims with the names of their runs and procedures: the runs first."""
    names = [*(result.plan.name for result in results), *(outcome.settings.name for outcome in outcomes)]
    return [(name, judged) for name in names for judged in verdicts[name]]


def counted_cells(claims: Sequence[ClaimResult], shown: Sequence[Verdict]) -> list[str | Text]:
    """Return cells of the table of many runs: numbers of claims in words by verdict, and axis-range checks met."""
    if not claims:
        return ["no claims"]
    counts = count_verdicts(sentences(claims))
    return [*(Text(str(counts[verdict] or ""), COLOURS[verdict]) for verdict in shown),
            bounds_met(claims)]


def counted(items: Sequence[object], noun: str) -> str:
    """Number of items with the noun, such as "1 value"."""
    return f"{len(items)} {noun}" if len(items) == 1 else f"{len(items)} {noun}s"


def claims_markdown(results: Sequence[RunResult], verdicts: Judgements, outcomes: Sequence[Outcome] = ()) -> str:
    """Return claims in words and axis-range checks as tables in Markdown: run, claim, source, values and verdict.

    A user's own runs have tables of their own, before the thesis's.
    """
    own, packaged = own_and_packaged(results, outcomes)
    mine = claims_in_order(own.results, verdicts, own.outcomes)
    met = met_of(specification(judged for _, judged in mine))
    text = (f"# Your runs\n\n{f'{met} claims met.' if met else 'No claims.'}\n\n"
            f"{claims_table('claim', mine, 'expected')}" if own else "")
    if not packaged:
        return TAG.sub("&lt;", visible(text))
    claims = claims_in_order(packaged.results, verdicts, packaged.outcomes)
    counting = those_that_count(judged for _, judged in claims)
    subjects = counted(packaged.results, "run") + (
        f" and {counted(packaged.outcomes, 'procedure')}" if packaged.outcomes else "")
    modified = [f"- `{result.plan.name}` is a {modification(result)}\n" for result in packaged.results
                if result.modified]
    notice = "".join(modified) + "\nVerdicts on the thesis are for its own runs.\n\n" if modified else ""
    of_axes = bounds_in_words(counting)
    text += ("\n# The thesis\n\n" if own else "") + (
        (f"{counted(sentences(counting), 'claim')} on {subjects}.\n\n{kinds_markdown(counting)}\n"
         if claims or not notice else "")
        + (f"{of_axes}.\n\n" if of_axes else "") + notice)
    for kind, name in CLAIM_KINDS.items():
        rows = [row for row in claims if row[1].claim.figure is None and row[1].claim.kind == kind]
        text += f"## {name.capitalize()}\n\n{claims_table('claim', rows)}\n" if rows else ""
    of_figures = [row for row in claims if row[1].claim.figure is not None]
    text += f"## Axis-range checks\n\n{claims_table('check', of_figures)}" if of_figures else ""
    return TAG.sub("&lt;", visible(text))


def kinds_markdown(claims: Sequence[ClaimResult]) -> str:
    """Return the numbers of the thesis's sentences by kind and by verdict, as a table in Markdown.

    For those that reproduce, if any, it has the numbers of claims for which a value was chosen, or was given to the
    plant.
    """
    totals = count_verdicts(sentences(claims))
    shown = [verdict for verdict in VERDICTS if totals[verdict]]
    apart = {"reproduced, not independent": "chose", "reproduced, given to the plant": "given"}   # heads, and keys
    apart = apart if totals["reproduced"] else {}
    rows = []
    for name, of_kind in [*by_kind(claims).items(), ("all", sentences(claims))]:
        counts = count_verdicts(of_kind)
        rows.append((name, len(of_kind), *(counts[verdict] or "–" for verdict in shown),
                     *(sum(claim.verdict == "reproduced" and getattr(claim.claim, key) is not None for claim in of_kind)
                       or "–" for key in apart.values())))
    return markdown_table(["what is claimed", "claims", *shown, *apart], rows)


def claims_table(noun: str, claims: Sequence[tuple[str, ClaimResult]], expected: str = "thesis value") -> str:
    """Return claims of one kind with the names of their runs or procedures, as a table in Markdown."""
    return markdown_table(("run", noun, "source", expected, "here", "verdict"), (
        (f"`{name}`", judged.claim.text, judged.claim.cited, judged.claim.criterion, judged.measured_text,
         f"**{judged.verdict}**: {judged.note}" if judged.note else judged.verdict) for name, judged in claims))


def outcome_line(result: RunResult, metrics: Metrics) -> str:
    """Return a line on how the run ended, with its largest error at the end."""
    errors = [] if metrics.ended_off else worst_of(result.plan, metrics.end_errors)
    return result.ending + (": " if errors and result.ending == COMPLETED else ", " if errors else "") + ", ".join(
        f"largest end error {error}" for error in errors)


def sentence(result: RunResult, claims: Sequence[ClaimResult]) -> str:
    """Return the simulated time of a run, its worst error and the number of claims that hold; empty if it did not
    complete.
    """
    if result.metrics is None:
        return ""
    tracking = {tracking.axis: tracking.peak_tracking_error for tracking in result.metrics.tracking}
    at_end = {} if result.metrics.ended_off else result.metrics.end_errors   # the ending has the errors already
    errors = worst_of(result.plan, tracking or at_end)
    return "; ".join([f"simulated for {result.time[-1]:.4g} s, {result.ending}", *(
        f"worst {'tracking error' if tracking else 'error at the end'} {error}" for error in errors),
        *sums(claims)[:1]])


def sums(claims: Sequence[ClaimResult]) -> list[str]:
    """Return how many of the judged claims hold, and how many of the axis-range checks; empty without claims."""
    judged = [claim.verdict for claim in [*specification(claims), *sentences(claims)]
              if claim.verdict not in ("not testable", "not run", "modified run")]
    good = sum(verdict in ("reproduced", "met") for verdict in judged)
    return [*([f"{good} of {counted(judged, 'claim')} hold{'s' if len(judged) == 1 else ''}"] if judged else []),
            *([f"{bounds_met(claims)} axis-range checks met"] if bounds_met(claims) else [])]


def short_outcome(result: RunResult) -> str:
    """Return the same in a few words for a table: the cause of a failure, or the error at the end."""
    if result.metrics is None:
        return result.ending
    said = ending(result.plan, result.metrics, brief=True)
    return ", ".join([said, *(worst_of(result.plan, result.metrics.end_errors) if said == COMPLETED else [])])


def worst_of(plan: RunPlan, errors: Mapping[str, float]) -> list[str]:
    """Return the largest error of the axes that move, and that of those that rotate, each with its axis."""
    worst: dict[str, tuple[float, str]] = {}
    for axis, error in errors.items():
        unit = plan.axes[axis].unit
        worst[unit] = max(worst.get(unit, (-1.0, "")), (error, axis), key=lambda pair: pair[0])
    return [f"{printed(error, unit)} on {axis}" for unit, (error, axis) in worst.items()]


def show_outcome(console: Console, outcome: Outcome, claims: Sequence[ClaimResult]) -> None:
    """Print the results of a procedure, and the claims about it with their verdicts."""
    console.print(heading(outcome.settings.name, outcome.settings.title))
    for table in outcome.tables:
        console.print(ResultTable(table.title, table.header, table.rows, left=len(table.header)))
    for note in outcome.notes:
        console.print(Text(f"note: {note}"))
    for table_of_claims in claim_tables(claims):
        console.print(table_of_claims)


def outcome_text(outcome: Outcome, claims: Sequence[ClaimResult]) -> str:
    """Return the output of `show_outcome` as text."""
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
    """Return the points of all curves as CSV, a row for each; reading the numbers gives the same bits.

    A figure without a number goes by its caption. A panel is named by its place in the figure, from 1, and by its
    ordinate over its abscissa. `margin` is the half width of the band about a curve, empty where it has none.
    """
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(CURVE_COLUMNS)
    for chart in charts:
        for k, panel in enumerate(chart.panels, start=1):
            name = f"{k}: {panel.y_title} over {panel.x_title}"
            for curve in panel.curves:
                place = csv_text(chart.number or chart.caption), name, csv_text(curve.label)
                margins = [""] * len(curve.x) if curve.margin is None else [repr(float(y)) for y in curve.margin]
                writer.writerows((*place, repr(float(x)), repr(float(y)), margin)
                                 for x, y, margin in zip(curve.x, curve.y, margins, strict=True))
    return text.getvalue()
