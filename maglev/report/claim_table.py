"""The claims of the thesis as HTML: summary, table with groups by run and procedure, and links to the figures."""

import re
from collections.abc import Iterable, Sequence
from html import escape
from typing import NamedTuple

from maglev.experiment.execution import RunResult
from maglev.judging.verdicts import (
    MET_OR_NOT,
    VERDICTS,
    ClaimResult,
    Judgements,
    Verdict,
    blames,
    bounds_in_words,
    count_verdicts,
    met_of,
    sentences,
    specification,
    those_that_count,
)
from maglev.procedures.outcome import Outcome
from maglev.report.findings import found_anchor, has_text, procedure_anchor
from maglev.report.plots.charts import ShownChart
from maglev.report.plots.figures import Shown, anchor, rig_name
from maglev.report.plots.marks import FIGURE_LIST, FIGURE_NUMBER, cited_figures
from maglev.report.status import Part, apart, is_listed, modification, run_status


class Look(NamedTuple):
    """How a verdict looks: CSS class, and a sign that needs no colour."""

    css: str
    sign: str


LOOKS: dict[Verdict, Look] = {
    "reproduced": Look("good", "✓"),
    "within 10 %": Look("close", "≈"),
    "not reproduced": Look("bad", "✗"),
    "not testable": Look("open", "?"),
    "not run": Look("none", "–"),
    "modified run": Look("none", "≠"),
    "met": Look("good", "⊂"),
    "not met": Look("bad", "⊄"),
}



def badge(verdict: Verdict) -> str:
    """Verdict in its colour, with its sign."""
    css, sign = LOOKS[verdict]
    return f'<span class="verdict {css}"><span aria-hidden="true">{sign}</span> {verdict}</span>'


def message(judgements: Judgements) -> str:
    """What came out, in a sentence or two; of what did not, how much has to do with assumed friction."""
    claims = sentences(those_that_count(result for of_one in judgements.values() for result in of_one))
    counts = count_verdicts(claims)
    if not counts["reproduced"] + counts["not reproduced"]:
        return ""
    missed = [each for each in claims if each.verdict == "not reproduced"]
    friction = len(blames(missed, "friction"))
    return (f'<p class="message"><strong>{counts["reproduced"]} of {len(claims)} claims reproduce</strong>, '
            f'{counts["within 10 %"]} more come within 10 %.'
            + (f" Of the {len(missed)} that do not, {friction} have guide friction among their reasons, which the "
               "thesis does not state and which is assumed here." if friction else "") + "</p>")


def verdict_options(judgements: Judgements) -> str:
    counts = count_verdicts(result for claims in judgements.values() for result in claims)
    return '<option value="">all</option>' + "".join(f"<option>{verdict}</option>" for verdict in VERDICTS
                                                     if counts[verdict])


def summary(results: Sequence[RunResult], judgements: Judgements) -> str:
    """Numbers of claims by verdict, of figure bounds, and of runs."""
    everything = those_that_count(result for claims in judgements.values() for result in claims)
    counts = count_verdicts(sentences(everything))
    cards = "".join(f'<li class="{LOOKS[verdict].css}"><strong>{counts[verdict]}</strong> '
                    f'<span aria-hidden="true">{LOOKS[verdict].sign}</span> {verdict}</li>' for verdict in VERDICTS
                    if verdict not in MET_OR_NOT and (counts[verdict] or verdict != "modified run"))
    of_axes, met = bounds_in_words(everything), met_of(specification(everything))
    failed = sum(result.failure is not None for result in results)
    return ((f"<p><strong>{met}</strong> of your claims are met.</p>\n" if met else "")
            + f'<ul class="cards">{cards}</ul>\n' + (f"<p>{of_axes}.</p>\n" if of_axes else "") +
            f'<p><strong>{len(results) - failed}</strong> runs completed, <strong>{failed}</strong> failed.</p>'
            + notice_of_modified(results))


def notice_of_modified(results: Sequence[RunResult]) -> str:
    """That runs are not the thesis's, if they are not; nothing otherwise."""
    modified = [f"<li>{escape(result.plan.name)}: {escape(modification(result))}</li>" for result in results
                if result.modified]
    heading = '\n<p class="status">Modified runs, whose claims have no verdict on the thesis:</p>'
    return f'{heading}<ul>{"".join(modified)}</ul>' if modified else ""


def filter_buttons(judgements: Judgements) -> str:
    """Buttons that show the claims of one verdict."""
    claims = [result for of_one in judgements.values() for result in of_one]
    counts, every = count_verdicts(those_that_count(claims)), count_verdicts(claims)

    def numbers(counted: int, shown: int) -> str:
        return f"({counted})" if shown == counted else f"({counted} + {shown - counted} of other readings)"

    buttons = ['<button type="button" data-verdict="" aria-pressed="true">all '
               f"{numbers(sum(counts.values()), sum(every.values()))}</button>"]
    buttons += [f'<button type="button" data-verdict="{verdict}" aria-pressed="false">'
                f'<span aria-hidden="true">{LOOKS[verdict].sign}</span> {verdict} '
                f"{numbers(counts[verdict], every[verdict])}</button>" for verdict in VERDICTS if every[verdict]]
    return f'<div class="filter" role="group" aria-label="Show claims by verdict">{"".join(buttons)}</div>'


def run_anchor(name: str) -> str:
    """Anchor of a run's group of claims."""
    return anchor("run", name)


def claim_anchor(name: str, k: int) -> str:
    """Anchor of the k-th claim about a run or a procedure."""
    return anchor("claim", name, str(k))


def claim_groups(results: Sequence[RunResult], judgements: Judgements, shown: Sequence[Shown | ShownChart],
                 outcomes: Sequence[Outcome] = ()) -> str:
    """Bodies of the table, one for each run, then one for each procedure; a user's own first, under a heading."""
    own, packaged = apart(results, outcomes)
    return "\n".join([*([heading_group("Your runs"), *part_groups(own, judgements, shown)] if own else []),
                      *([heading_group("The thesis")] if own and packaged else []),
                      *part_groups(packaged, judgements, shown)])


def heading_group(text: str) -> str:
    """Body of the table with nothing but a heading."""
    return f'<tbody class="part"><tr><th colspan="5" scope="rowgroup">{escape(text)}</th></tr></tbody>'


def part_groups(part: Part, judgements: Judgements, shown: Sequence[Shown | ShownChart]) -> list[str]:
    """Bodies of the table about runs and procedures."""
    return ([run_group(result, judgements.get(result.plan.name, ()), shown)
             for result in part.results if is_listed(result, judgements)]
            + [procedure_group(outcome, judgements.get(outcome.settings.name, ()), shown)
               for outcome in part.outcomes])


def run_group(result: RunResult, claims: Sequence[ClaimResult], shown: Sequence[Shown | ShownChart]) -> str:
    """Body of the table with the claims about one run."""
    name = result.plan.name
    status = "".join(f'<p class="status">⚠ {escape(text)}</p>' for text in run_status(result))
    figures = [each for each in shown if isinstance(each, Shown) and each.has(name)]
    return claim_group(run_anchor(name), name, result.plan.title, status, figure_links(figures),
                       claim_rows(name, claims, [*figures, *shown]), rig_name(name, result.plan))


def procedure_group(outcome: Outcome, claims: Sequence[ClaimResult], shown: Sequence[Shown | ShownChart]) -> str:
    """Body of the table with the claims about one procedure."""
    name = outcome.settings.name
    charts = [each for each in shown if isinstance(each, ShownChart) and each.outcome is outcome]
    links = figure_links(charts)
    if has_text(outcome):
        links.append(f'<a href="#{found_anchor(name)}">{"Tables" if outcome.tables else "Notes"}</a>')
    return claim_group(procedure_anchor(name), name, outcome.settings.title, "", links,
                       claim_rows(name, claims, [*charts, *shown]), rig_name(name))


def claim_group(identifier: str, name: str, title: str, status: str, links: Sequence[str],
                rows: Sequence[str], rig: str) -> str:
    """Body of the table under a heading, with which stage it is about; status, links and rows are HTML."""
    where = f"<p>{', '.join(links)}</p>" if links else ""
    return (f'<tbody id="{identifier}" data-rig="{rig}"><tr class="run"><th colspan="5" scope="rowgroup">'
            f"<strong>{escape(name)}</strong> {escape(title)}{status}{where}</th></tr>\n"
            + "\n".join(rows or ['<tr class="empty"><td colspan="5">no claims</td></tr>']) + "</tbody>")


def claim_rows(name: str, claims: Sequence[ClaimResult], shown: Sequence[Shown | ShownChart]) -> list[str]:
    """Rows of the claims about a run or a procedure; the bounds of figures, which all read alike, fold into one."""
    own = next((each for each in shown if name in names_behind(each)), None)
    rows = {k: claim_row(claim_anchor(name, k), each, shown, own) for k, each in enumerate(claims)}
    bounds = [k for k, each in enumerate(claims) if each.claim.figure is not None]
    words = bounds_in_words(claims[k] for k in bounds) or f"{len(bounds)} bounds by the axes of figures"
    folded = [f'<tr class="bounds"><td colspan="5"><details><summary>{escape(words)}</summary><table><tbody>'
              + "\n".join(rows.pop(k) for k in bounds) + "</tbody></table></details></td></tr>"] if bounds else []
    return [*rows.values(), *folded]


def figure_links(shown: Iterable[Shown | ShownChart]) -> list[str]:
    return [f'<a href="#{each.id}">{escape(each.title)}</a>' for each in shown]


def claim_row(identifier: str, result: ClaimResult, shown: Sequence[Shown | ShownChart],
              own: Shown | ShownChart | None) -> str:
    """One claim; its source links to the figures, of those with the same number to the first; `own` has its curves.

    Bounds of figures leave out their text, which is the same of all.
    """
    claim = result.claim
    reason = f'<p class="reason">{escape(result.note)}</p>' if result.note else ""
    reason += what_if(result, own)
    cells = (("claim", escape(claim.text)), ("source", linked_source(claim.source, shown)),
             ("criterion", escape(unbroken(claim.criterion))),
             ("measured", escape(unbroken(result.measured_text))),
             ("verdict", f"{badge(result.verdict)}{reason}"))
    return (f'<tr id="{identifier}" data-verdict="{result.verdict}">'
            + "".join(f'<td data-label="{label}">{content or "–"}</td>' for label, content in cells
                      if label != "claim" or claim.figure is None) + "</tr>")


def what_if(result: ClaimResult, shown: Shown | ShownChart | None = None) -> str:
    """What becomes of a claim without the friction that its reason blames, to unfold; with a link to its curves."""
    if result.without is None:
        return ""
    measured = f": {escape(unbroken(result.without.measured_text))}" if result.without.measured_text else ""
    link = (f' <a href="#{shown.id}" data-without="{shown.id}">Its curves in {escape(shown.title)}</a>'
            if shown is not None else "")
    verdict = ("a run without it does not complete" if result.without.verdict == "not run"
               else badge(result.without.verdict))
    return (f'<details class="what-if"><summary>What if friction were zero?</summary>'
            f"<p>{verdict}{measured}.{link}</p></details>")


def wording(result: ClaimResult) -> str:
    """A claim in words: its text or, as all bounds of figures have the same, its criterion."""
    return result.claim.text if result.claim.figure is None else unbroken(result.claim.criterion)


def unbroken(text: str) -> str:
    """The text with numbers and their units kept on one line."""
    return re.sub(r"(?<=\d) (?=%|(?:mm|µm|ms|[mµ]rad|kg|[sANV])\b)", "\N{NO-BREAK SPACE}", text)


def linked_source(source: str, shown: Iterable[Shown | ShownChart]) -> str:
    """Source of a claim with links to the figures of the page that it cites."""
    targets: dict[str, str] = {}
    for each in shown:
        targets.setdefault(str(each.number), each.id)

    def link(match: re.Match[str]) -> str:
        number = match.group()
        return f'<a href="#{targets[number]}">{number}</a>' if number in targets else number

    return FIGURE_LIST.sub(lambda found: FIGURE_NUMBER.sub(link, found.group()), escape(source))


def names_behind(shown: Shown | ShownChart) -> list[str]:
    """Names of a figure's runs, and of the procedures that these belong to: all that claims may be about."""
    if isinstance(shown, ShownChart):
        return shown.names
    procedures = [run.plan.procedure.name for run in shown.runs if run.plan.procedure is not None]
    return list(dict.fromkeys([*(run.plan.name for run in shown.runs), *procedures]))


def claims_of_figure(shown: Shown | ShownChart, judgements: Judgements) -> str:
    """Claims about a figure, linked: those of what it shows that cite it, or all of a run if it has no number."""
    names = names_behind(shown)
    every = isinstance(shown, Shown) and shown.number is None
    items = []
    for name in names:
        for k, result in enumerate(judgements.get(name, ())):
            if every or shown.number in cited_figures(result.claim.source):
                reason = f': <span class="reason">{escape(result.note)}</span>' if result.note else ""
                measured = f" Measured: {escape(unbroken(result.measured_text))}" if result.measured_text else ""
                wanted = f" ({escape(unbroken(result.claim.criterion))})" if result.claim.figure is None else ""
                items.append(f'<li data-verdict="{result.verdict}"><a href="#{claim_anchor(name, k)}">'
                             f"{badge(result.verdict)}</a> {escape(wording(result))}{wanted}.{measured}{reason}"
                             f"{what_if(result)}</li>")
    return f'<ul class="claims">{"".join(items)}</ul>' if items else ""
