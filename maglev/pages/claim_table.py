"""The claims of the thesis as HTML: summary, table with groups by run and procedure, and links to the figures."""

import re
from collections.abc import Iterable, Sequence
from html import escape

from maglev.pages.charts import ShownChart
from maglev.pages.figures import Shown, anchor, stage_name
from maglev.pages.findings import typeset
from maglev.pages.marks import FIGURE_LIST, FIGURE_NUMBER, cited_figures
from maglev.pages.run_text import counted, sentence
from maglev.pages.status import is_listed, modification, own_and_packaged, run_status
from maglev.runs.execution import RunResult
from maglev.runs.procedure_outcome import Outcome
from maglev.runs.verdicts import (
    MET_OR_NOT,
    VERDICTS,
    ClaimResult,
    Judgements,
    Verdict,
    bounds_in_words,
    by_kind,
    count_verdicts,
    met_of,
    sentences,
    specification,
    those_that_blame_friction,
    those_that_count,
)

MOST_TOLD = 4   # runs that have a sentence in the head of a report


# CSS class of a verdict, and a sign that needs no colour.
LOOKS: dict[Verdict, tuple[str, str]] = {
    "reproduced": ("good", "✓"), "within 10 %": ("close", "≈"), "no difference": ("bad", "="),
    "not reproduced": ("bad", "✗"), "not testable": ("open", "?"), "not run": ("none", "–"),
    "modified run": ("none", "≠"), "met": ("good", "⊂"), "not met": ("bad", "⊄"),
}


def badge(verdict: Verdict) -> str:
    """Verdict in its colour, with its sign."""
    css, sign = LOOKS[verdict]
    return f'<span class="verdict {css}"><span aria-hidden="true">{sign}</span> {verdict}</span>'


def message(judgements: Judgements) -> str:
    """Return the result in a sentence or two, printed numbers first, and the misses that have friction among their
    reasons.
    """
    claims = sentences(those_that_count(result for of_one in judgements.values() for result in of_one))
    counts = count_verdicts(claims)
    if not counts["reproduced"] + counts["not reproduced"]:
        return ""
    first, *others = (f"{count_verdicts(of_kind)['reproduced']} of {len(of_kind)} {name}"
                      for name, of_kind in by_kind(claims).items())
    missed = [judged for judged in claims if judged.verdict in ("no difference", "not reproduced")]
    friction = len(those_that_blame_friction(missed))
    who = "The one that does not" if len(missed) == 1 else f"Of the {len(missed)} that do not, {friction}"
    return (f'<p class="message"><strong>{first} reproduce</strong>{", and " if others else ""}{", ".join(others)}.'
            + (f" {who} {'has' if friction == 1 else 'have'} guide friction among the reasons: the thesis does not "
               "state it, so it is assumed here." if friction else "") + "</p>")


def summarised_runs(results: Sequence[RunResult], judgements: Judgements) -> list[RunResult]:
    """Return the runs whose ends the head of a report states: all if there are few, or else none."""
    told = [result for result in results if result.metrics is not None and is_listed(result, judgements)]
    return told if len(told) <= MOST_TOLD else []


def run_sentences(results: Sequence[RunResult], judgements: Judgements) -> str:
    """Return a sentence on the end of each run, if a report has few of them."""
    return "".join(f'<p class="said"><strong>{escape(result.plan.name)}</strong>: '
                   f"{typeset(sentence(result, judgements.get(result.plan.name, ())))}.</p>"
                   for result in summarised_runs(results, judgements))


def verdict_options(judgements: Judgements) -> str:
    """Choices of a verdict, with how many claims have it, and how many more of other readings of an experiment."""
    claims = [result for of_one in judgements.values() for result in of_one]
    counts, every = count_verdicts(those_that_count(claims)), count_verdicts(claims)

    def option(value: str, words: str, counted: int, shown: int) -> str:
        more = f" + {shown - counted} of other readings" if shown > counted else ""
        return f'<option value="{value}">{words} ({counted}{more})</option>'

    return option("", "all", sum(counts.values()), sum(every.values())) + "".join(
        option(verdict, f"{LOOKS[verdict][1]} {verdict}", counts[verdict], every[verdict])
        for verdict in VERDICTS if every[verdict])


def claims_summary(results: Sequence[RunResult], judgements: Judgements) -> str:
    """Return the numbers of claims by kind of statement and by verdict, of axis-range checks, and of runs."""
    everything = those_that_count(result for claims in judgements.values() for result in claims)
    of_axes, met = bounds_in_words(everything), met_of(specification(everything))
    failed = sum(result.failure is not None for result in results)
    modified = "".join(f"<li>{escape(result.plan.name)}: {escape(modification(result))}</li>" for result in results
                       if result.modified)
    return ((f"<p><strong>{met}</strong> of your claims are met.</p>\n" if met else "")
            + kind_table(everything) + (f"<p>{of_axes}.</p>\n" if of_axes else "")
            + (f"<p><strong>{failed}</strong> of {counted(results, 'run')} did not complete.</p>" if failed else "")
            + (f'\n<p class="status">Modified runs, whose claims have no verdict on the thesis:</p><ul>{modified}</ul>'
               if modified else ""))


def kind_table(claims: Sequence[ClaimResult]) -> str:
    """Return the table of the thesis's sentences by verdict and by kind, with the sums; empty if there are none."""
    kinds = by_kind(claims)
    columns = kinds if len(kinds) == 1 else {**kinds, "all": sentences(claims)}
    counts = [count_verdicts(of_kind) for of_kind in columns.values()]
    shown = [verdict for verdict in VERDICTS if counts[-1][verdict] and verdict not in MET_OR_NOT]
    if len(columns) * len(shown) < 2:   # the sentence above it says this
        return ""
    heads = "".join(f'<th scope="col">{name}</th>' for name in columns)
    body = "\n".join(
        f'<tr><th scope="row">{badge(verdict)}</th>' + "".join(f"<td>{count[verdict] or '–'}</td>" for count in counts)
        + "</tr>" for verdict in shown)
    sums = "".join(f"<td>{len(of_kind)}</td>" for of_kind in columns.values())
    total = f'\n<tr><th scope="row">all</th>{sums}</tr>' if len(shown) > 1 else ""
    return (f'<div class="wide"><table class="kinds"><thead><tr><th scope="col">claims</th>{heads}</tr></thead>\n'
            f'<tbody>{body}{total}</tbody></table></div>\n')


def claim_groups(results: Sequence[RunResult], judgements: Judgements, shown: Sequence[Shown | ShownChart],
                 outcomes: Sequence[Outcome] = ()) -> str:
    """Bodies of the table, one for each run, then one for each procedure; a user's own first, under a heading."""
    own, packaged = own_and_packaged(results, outcomes)
    groups = []
    for part, heading in ((own, "Your runs"), (packaged, "The thesis")):
        if own and part:
            groups.append(f'<tbody class="part"><tr><th colspan="5" scope="rowgroup">{heading}</th></tr></tbody>')
        groups += [run_group(result, judgements.get(result.plan.name, ()), shown)
                   for result in part.results if is_listed(result, judgements)]
        groups += [procedure_group(outcome, judgements.get(outcome.settings.name, ()), shown)
                   for outcome in part.outcomes]
    return "\n".join(groups)


def run_group(result: RunResult, claims: Sequence[ClaimResult], shown: Sequence[Shown | ShownChart]) -> str:
    name = result.plan.name
    status = "".join(f'<p class="status">⚠ {escape(text)}</p>' for text in run_status(result))
    status += "".join(f"<p>{typeset(said)}</p>" for said in [sentence(result, claims)] if said)
    figures = [figure for figure in shown if isinstance(figure, Shown) and figure.has(name)]
    return claim_group(anchor("run", name), name, result.plan.title, status, figure_links(figures),
                       claim_rows(name, claims, [*figures, *shown]), stage_name(name, result.plan))


def procedure_group(outcome: Outcome, claims: Sequence[ClaimResult], shown: Sequence[Shown | ShownChart]) -> str:
    name = outcome.settings.name
    charts = [chart for chart in shown if isinstance(chart, ShownChart) and chart.outcome is outcome]
    links = figure_links(charts)
    if outcome.tables or outcome.notes:
        links.append(f'<a href="#{anchor("found", name)}">{"Tables" if outcome.tables else "Notes"}</a>')
    return claim_group(anchor("procedure", name), name, outcome.settings.title, "", links,
                       claim_rows(name, claims, [*charts, *shown]), stage_name(name))


def claim_group(identifier: str, name: str, title: str, status: str, links: Sequence[str],
                rows: Sequence[str], stage: str) -> str:
    """Body of the table under a heading, with which stage it is about; status, links and rows are HTML."""
    where = f"<p>{', '.join(links)}</p>" if links else ""
    return (f'<tbody id="{identifier}" data-stage="{stage}"><tr class="run"><th colspan="5" scope="rowgroup">'
            f"<strong>{escape(name)}</strong> {escape(title)}{status}{where}</th></tr>\n"
            + "\n".join(rows or ['<tr class="empty"><td colspan="5">no claims</td></tr>']) + "</tbody>")


def claim_rows(name: str, claims: Sequence[ClaimResult], shown: Sequence[Shown | ShownChart]) -> list[str]:
    """Return rows of the claims about a run or a procedure; axis-range checks, which all read alike, fold into one."""
    own = next((figure for figure in shown if name in figure.names), None)
    rows = {k: claim_row(anchor("claim", name, str(k)), judged, shown, own) for k, judged in enumerate(claims)}
    bounds = [k for k, judged in enumerate(claims) if judged.claim.figure is not None]
    words = bounds_in_words(claims[k] for k in bounds) or f"{len(bounds)} axis-range checks"
    folded = [f'<tr class="bounds"><td colspan="5"><details><summary>{escape(words)}</summary><table><tbody>'
              + "\n".join(rows.pop(k) for k in bounds) + "</tbody></table></details></td></tr>"] if bounds else []
    return [*rows.values(), *folded]


def figure_links(shown: Iterable[Shown | ShownChart]) -> list[str]:
    return [f'<a href="#{figure.id}">{escape(figure.title)}</a>' for figure in shown]


def claim_row(identifier: str, result: ClaimResult, shown: Sequence[Shown | ShownChart],
              own: Shown | ShownChart | None) -> str:
    """One claim; its source links to the figures, of those with the same number to the first; `own` has its curves.

    Axis-range checks all have the same text, which is left out.
    """
    claim = result.claim
    reason = why(result) + what_if(result, own)
    cells = (("claim", escape(claim.text)), ("source", linked_source(claim.cited, shown)),
             ("criterion", typeset(claim.criterion)),
             ("measured", typeset(result.measured_text)),
             ("verdict", f"{badge(result.verdict)}{reason}"))
    return (f'<tr id="{identifier}" data-verdict="{result.verdict}">'
            + "".join(f'<td data-label="{label}">{content or "–"}</td>' for label, content in cells
                      if label != "claim" or claim.figure is None) + "</tr>")


def why(result: ClaimResult) -> str:
    """Return the reason of a verdict, to unfold; empty if none is known or needed."""
    return (f'<details class="why"><summary>why</summary><p class="reason">{escape(result.note)}</p></details>'
            if result.note else "")


def what_if(result: ClaimResult, shown: Shown | ShownChart | None = None) -> str:
    """Return the verdict of a claim without the friction that its reason blames, to unfold; with a link to its curves.
    """
    if result.without is None:
        return ""
    measured = f": {typeset(result.without.measured_text)}" if result.without.measured_text else ""
    link = (f' <a href="#{shown.id}" data-without="{shown.id}">Its curves in {escape(shown.title)}</a>'
            if shown is not None else "")
    verdict = ("a run without it does not complete" if result.without.verdict == "not run"
               else badge(result.without.verdict))
    return (f'<details class="what-if"><summary>What if friction were zero?</summary>'
            f"<p>{verdict}{measured}.{link}</p></details>")


def linked_source(source: str, shown: Iterable[Shown | ShownChart]) -> str:
    """Source of a claim with links to the figures of the page that it cites."""
    targets: dict[str, str] = {}
    for figure in shown:
        targets.setdefault(str(figure.number), figure.id)

    def link(match: re.Match[str]) -> str:
        number = match.group()
        return f'<a href="#{targets[number]}">{number}</a>' if number in targets else number

    return FIGURE_LIST.sub(lambda match: FIGURE_NUMBER.sub(link, match.group()), escape(source))


def claims_of_figure(shown: Shown | ShownChart, judgements: Judgements) -> str:
    """Return the linked claims about a figure: those that cite it, or all of its run if it has no number."""
    every = isinstance(shown, Shown) and shown.number is None
    items = []
    for name in shown.names:
        for k, result in enumerate(judgements.get(name, ())):
            if every or shown.number in cited_figures(result.claim.source):
                measured = f" Measured: {typeset(result.measured_text)}" if result.measured_text else ""
                # All axis-range checks have one text.
                words = typeset(result.claim.criterion)
                words = words if result.claim.figure is not None else f"{escape(result.claim.text)} ({words})"
                items.append(f'<li data-verdict="{result.verdict}"><a href="#{anchor("claim", name, str(k))}">'
                             f"{badge(result.verdict)}</a> {words}.{measured} {why(result)}"
                             f"{what_if(result)}</li>")
    return f'<ul class="claims">{"".join(items)}</ul>' if items else ""
