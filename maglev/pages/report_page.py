"""The page: claims with their verdicts, tables and figures, a moving picture, and the provenance."""

import json
import os
from collections.abc import Collection, Iterable, Sequence
from datetime import UTC, datetime
from functools import partial
from html import escape
from pathlib import Path
from time import time
from typing import get_args
from urllib.parse import quote

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.environment import DATE, number_in
from maglev.pages import claim_table, findings, shell
from maglev.pages.charts import ShownChart, by_number, shown_charts
from maglev.pages.figures import Shown, anchor, law_of, moving_runs, read_figures, shown_figures, stage_name
from maglev.pages.findings import typeset
from maglev.pages.live_content import NAME, can_run_live, live_address
from maglev.pages.plot_data import figure_data, moving, runs_data
from maglev.pages.run_text import sentence
from maglev.pages.status import is_listed, modification, run_status
from maglev.pages.what_if import NOTHING, Again
from maglev.runs.execution import RunResult
from maglev.runs.procedure_outcome import Outcome
from maglev.runs.results import ResultFiles
from maglev.runs.verdicts import Judgements
from maglev.scenario.layers import packaged_runs, scenario_of
from maglev.scenario.options import Format

read = partial(shell.read, folder=Path(__file__).with_name("report"))
# Heights: of a panel, of the buttons above, of its times, which one panel has, of the names of events above the first.
PIXELS, TOOLS, TIMES, EVENTS = 204, 40, 28, 14
STYLE = read("plots/plots.css") + read("style.css")   # of pages of results
PLOT_SCRIPTS = tuple(f"plots/{name}.js" for name in ("series", "plot", "plot_hands", "charts", "plots"))
SCRIPTS = (*PLOT_SCRIPTS, "player.js", "index.js")
PLAYER = '<section id="moving" aria-label="Moving picture"><div id="player"></div></section>'
TITLE = "Maglev stages: the experiments of the thesis, simulated"   # of more than one run
ABOUT = """<p>R. B. Owen's thesis <cite>Implementation of High Precision Positioning Systems Using Contactless Magnetic
Levitation</cite> (University of Toronto, 2005) shows what two levitated stages do under several controllers. Here its
experiments are run again as co-simulations of a plant and a controller, and each of its claims is held against what the
simulation measures.</p>"""


def write_report(path: Path, results: Sequence[RunResult], judgements: Judgements,
                 outcomes: Sequence[Outcome] = (), frictionless: Again = NOTHING) -> None:
    """Write the report of runs, also of those that failed, as one HTML page that needs no network.

    The file appears under its name when it is complete; a former file is intact until then.
    """
    shell.publish(path, report_page(results, judgements, outcomes, path.parent, frictionless))


def report_page(results: Sequence[RunResult], judgements: Judgements, outcomes: Sequence[Outcome] = (),
                folder: Path | None = None, frictionless: Again = NOTHING) -> str:
    """Text of the page; it links to the live page and to files of runs if they are in its folder."""
    live = folder is not None and (folder / NAME).is_file()
    figures = shown_figures(read_figures(), results)
    shown = by_number(figures, shown_charts(outcomes))
    section = findings.findings_section(outcomes)
    title = f"{results[0].plan.name}: {results[0].plan.title}" if len(results) == 1 else TITLE
    drawn = {figure.id: figure_data(figure, judgements, frictionless) for figure in shown}
    films = {run.plan.name: film for run in moving_runs(results) if (film := moving({law_of(run): run}))}
    data = {"runs": runs_data(results, figures, frictionless.runs), "figures": drawn, "moving": films}
    told = {run.plan.name for run in claim_table.summarised_runs(results, judgements)}
    message = claim_table.run_sentences(results, judgements) + claim_table.message(judgements)
    return shell.page(
        "report", escape(title), message, STYLE + read("claims.css"), read("page.html"),
        heading=escape(title),
        thesis="" if all(result.modified or result.plan.own for result in results) else ABOUT,
        stages="".join(f'<option value="{stage.name}">{escape(stage.title)}</option>'
                       for stage in PACKAGED_STAGES.values()),
        message=message, moving=PLAYER if films else "",
        unsearched="" if len(results) > 1 or any(judgements.values()) else " hidden",
        numbered="<p>Numbered as in the thesis.</p>\n" if any(figure.number for figure in shown) else "",
        verdicts=claim_table.verdict_options(judgements),
        index="\n".join(f'<li><a href="#{figure.id}"><b>{escape(figure.title)}</b> '
                        f"<span>{escape(figure.caption)}</span></a></li>" for figure in shown),
        origin=escape(page_origin(results)),
        command=command_line(results),
        summary=claim_table.claims_summary(results, judgements),
        claims=claim_table.claim_groups(results, judgements, shown, outcomes),
        links='<li><a href="#identification">Identification</a></li>' if section else "",
        findings=section,
        figures="\n".join(figure_element(figure, judgements, folder, "without" in drawn[figure.id], told)
                          for figure in shown)
        or f"<p>No {'figure shows these runs' if any(len(run.time) for run in results) else 'run was recorded'}.</p>",
        assumptions=read("assumptions.html"),
        descriptions="\n".join(
            f"<dt>{escape(result.plan.name)}: {escape(result.plan.title)}{live_link(result) if live else ''}</dt>"
            f"<dd>{escape(result.plan.description) or 'no description'}</dd>" for result in results),
        data=json_in_html(data),
        scripts=shell.scripts(shell.scene(), *map(read, SCRIPTS)))


def page_origin(results: Sequence[RunResult]) -> str:
    """Return how many of the package's runs the report has, if any, and with what, when and where all were run."""
    here = sum(not result.plan.own and scenario_of(result.plan.name) is not None for result in results)
    made = dict.fromkeys((provenance.version, provenance.commit, provenance.python)
                          for provenance in (result.provenance for result in results) if provenance is not None)
    day = datetime.fromtimestamp(number_in(DATE) if os.environ.get(DATE) else time(), UTC).date()
    share = f"{here} of the {len(packaged_runs())} runs of the package, " if here else ""
    return "; ".join([share + day.isoformat(),
                      *(f"Maglev FMUs {version}{f' ({commit})' if commit else ''}, Python {python}"
                        for version, commit, python in made)])


def command_line(results: Iterable[RunResult]) -> str:
    """The commands that ran what a page shows, each with a button that copies it; empty if Python did."""
    commands = dict.fromkeys(run.provenance.command for run in results if run.provenance is not None)
    return "".join(f'<p><code>{escape(command)}</code> <button type="button" class="copy">Copy</button></p>'
                   for command in commands if command.startswith("maglev "))


def file_links(folder: Path | None, name: str) -> str:
    """Links to the files of a run that are in the folder of the page."""
    endings = [ending for ending in (*get_args(Format), "json")
               if folder and ResultFiles(folder, name).file(ending).is_file()]
    return "".join(f' <a class="screen" download href="{escape(quote(f"{name}.{ending}"))}" '
                   f'aria-label="{ending.upper()} of {escape(name)}">{ending.upper()}</a>' for ending in endings)


def json_in_html(data: object) -> str:
    """JSON that can stand in a script element: no tag can begin in it."""
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def figure_element(shown: Shown | ShownChart, judgements: Judgements, folder: Path | None, frictionless: bool,
                   told: Collection[str]) -> str:
    """Return one figure: caption, its runs with links to live page and files, place for the plot, claims about it.

    The ends of its runs stand there, except of those that were `told` before.
    """
    switch = (f'<p><button type="button" class="what-if" data-switch="{shown.id}" aria-pressed="false" hidden>'
              "What if friction were zero?</button></p>\n" if frictionless else "")
    if isinstance(shown, ShownChart):
        name = shown.outcome.settings.name
        stage = stage_name(name)
        about = f'<li><a href="#{anchor("procedure", name)}">{escape(name)}</a></li>'
    else:
        stage = " ".join(sorted({stage_name(run.plan.name, run.plan) for run in shown.runs}))
        about = "".join(f"<li>{run_about(run, judgements, folder, run.plan.name in told)}</li>" for run in shown.runs)
    return (f'<figure id="{shown.id}" data-stage="{stage}"><figcaption><h3>{escape(shown.title)}</h3>'
            f'<p>{escape(shown.caption)}</p><ul class="runs">{about}</ul></figcaption>\n{switch}'
            f'<div class="beside"><div class="plot" data-figure="{shown.id}" style="min-height:{plot_height(shown)}px">'
            "</div>\n"
            f"{claim_table.claims_of_figure(shown, judgements)}</div></figure>")


def plot_height(shown: Shown | ShownChart) -> int:
    """Height of a plot, px; panels of runs have their times below the last one alone."""
    if isinstance(shown, ShownChart):
        return TOOLS + PIXELS * len(shown.chart.panels)
    panels, events = len(shown.panels), any(run.plan.windows for run in shown.recorded)
    return TOOLS + PIXELS * panels - TIMES * (panels - 1) + EVENTS * events


def run_about(run: RunResult, judgements: Judgements, folder: Path | None, told: bool) -> str:
    """Return the name of a run with links, its end unless that was told before, and its errors."""
    name = run.plan.name
    linked = f'<a href="#{anchor("run", name)}">{escape(name)}</a>' if is_listed(run, judgements) else escape(name)
    said = "" if told else typeset(sentence(run, judgements.get(name, ())))
    warned = [modification(run)] if said and modification(run) else [] if said else run_status(run)
    live = live_link(run) if folder and (folder / NAME).is_file() else ""
    return "; ".join([linked + live + file_links(folder, name), *([said] if said else []),
                      *(f'<span class="status">⚠ {escape(text)}</span>' for text in warned)])


def live_link(run: RunResult) -> str:
    """Return a link that opens a run in the live page; empty if the page cannot run it in the same way."""
    if run.modified or not can_run_live(run.plan):
        return ""
    name = run.plan.name
    return (f' <span class="screen">(<a href="{escape(live_address(name))}" aria-label="open this run live: '
            f'{escape(name)}">open this run live</a>)</span>')
