"""The page of a study: histograms with limits, response surfaces, parallel coordinates, sensitivity, worst samples."""

import math
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
import pyarrow as pa

from maglev.live.link import NAME as LIVE_PAGE
from maglev.live.link import has_live_page
from maglev.quantities import PRINTED_UNITS, metric_text
from maglev.report.findings import html_table
from maglev.report.page import json_in_html, read
from maglev.studies.page.again import command_of
from maglev.studies.page.live_links import live_link, why_not_live
from maglev.studies.page.plotting import plotly_script, require_plotly
from maglev.studies.page.sensitivity import Indices, sensitivity
from maglev.studies.page.text import limits_text, metrics_of
from maglev.units import factor, known_unit
from maglev_files.whole_file import write_whole

FOLDER = Path(__file__).parent
SCRIPTS = ("plots/series.js",)   # of the report: its data, and what goes wrong
OWN_SCRIPTS = ("look.js", "parallel.js", "study.js")
MOST_DRAWN = 5000   # samples that are drawn: a page of 10⁵ would be as large as its dataset
MOST_WORST = 10     # samples that are listed


def write_page(path: Path, table: pa.Table, about: Mapping[str, Any]) -> None:
    """Write the page of a study, which needs no network; ScenarioError if plotly is not installed."""
    require_plotly()
    write_whole(path, page(table, about, has_live_page(path)))


def page(table: pa.Table, about: Mapping[str, Any], live: bool = False) -> str:
    """Text of the page; `live` is whether the live page lies beside it."""
    count, passing = table.num_rows, sum(table["passed"].to_pylist())
    failures = sum(why is not None for why in table["failure"].to_pylist())
    drawn = np.unique(np.linspace(0, count - 1, min(count, MOST_DRAWN)).astype(int))
    metrics = [(name, unit) for name, unit, values in metrics_of(table) if varies(values)]
    indices, notes = sensitivity(table, about)
    provenance = about["provenance"]
    return Template((FOLDER / "study.html").read_text(encoding="utf-8")).substitute(
        style=read("style.css"), name=escape(about["name"]), title=escape(about["title"]),
        description=escape(about["description"]),
        summary=f"{passing} of {count} samples pass{f', {failures} were not flown to their ends' if failures else ''}. "
                f"Scenario {escape(about['scenario'])}; {design_text(about)}."
                + (f" Drawn are {len(drawn)} of them." if len(drawn) < count else ""),
        table=quantiles_table(table, about), worst=worst_table(table, about, metrics, live),
        sensitivity="\n".join(f"<p>{escape(note)}</p>" for note in notes) + indices_table(indices),
        provenance=f"maglev-fmus {escape(provenance['version'])}"
                   + (f", commit {escape(provenance['commit'])}" if provenance["commit"] else "")
                   + f", Python {escape(provenance['python'])}; "
                   + "; ".join(f"{escape(fmu['name'])}: {escape(fmu['file'])} ({escape(fmu['kind'])}, "
                               f"{escape(fmu['guid'])})" for fmu in provenance["fmus"])
                   + "".join(f"; {escape(change)}" for change in provenance["changes"]),
        data=json_in_html(data(table, about, metrics, drawn, indices)), plotly=plotly_script(),
        scripts="\n".join(f"<script>\n{read(name)}</script>" for name in SCRIPTS)
                + "\n".join(f"<script>\n{(FOLDER / name).read_text(encoding='utf-8')}</script>"
                            for name in OWN_SCRIPTS))


def varies(values: np.ndarray[Any, np.dtype[np.float64]]) -> bool:
    """Whether a metric differs between samples, so that it is worth a plot."""
    return len(values) > 0 and values.min() != values.max()


def design_text(about: Mapping[str, Any]) -> str:
    """The design in words."""
    design = about["design"]
    if design["kind"] == "grid":
        return "every combination of the values"
    return f"design: {design['kind']}, {design['samples']} samples, seed {design['seed']}"


def data(table: pa.Table, about: Mapping[str, Any], metrics: Sequence[tuple[str, str]],
         drawn: np.ndarray[Any, np.dtype[np.intp]], indices: Sequence[Indices]) -> dict[str, Any]:
    """What the page's script draws."""
    chosen = table.take(pa.array(drawn))
    units = {field.name: (field.metadata or {}).get(b"unit", b"").decode() for field in table.schema}
    varied = [each["name"] for each in about["vary"]]
    columns = []
    for name in [*varied, *(name for name, _ in metrics)]:
        unit = PRINTED_UNITS.get(units[name], units[name])
        scale = 1.0 / factor(unit) if known_unit(unit) else 1.0
        limits = {key: scale * value for key, value in about["limits"].get(name, {}).items() if value is not None}
        columns.append({"name": name, "unit": unit, "limits": limits, "values": [
            None if value is None or not math.isfinite(value) else float(f"{scale * value:.6g}")
            for value in chosen[name].to_pylist()]})
    return {"samples": drawn.tolist(), "varied": len(varied), "columns": columns,
            "grid": about["design"]["kind"] == "grid", "passed": [int(each) for each in chosen["passed"].to_pylist()],
            "sensitivity": [{"metric": each.metric, "first": list(each.first.values()),
                             "firstError": list(each.first_confidence.values()), "total": list(each.total.values()),
                             "totalError": list(each.total_confidence.values())} for each in indices]}


def quantiles_table(table: pa.Table, about: Mapping[str, Any]) -> str:
    """Least, median and largest value of every metric, its limits, and how many samples are beyond them."""
    rows = []
    for name, unit, values in metrics_of(table):
        if not len(values):
            continue
        quantiles = np.quantile(values, [0.0, 0.5, 1.0], method="nearest").tolist()
        cells = [metric_text(name, each, unit) for each in quantiles]
        limits = about["limits"].get(name, {})
        low, high = (limits.get("min"), limits.get("max"))
        beyond = int(np.sum((values < (-math.inf if low is None else low)) | (values > (math.inf if high is None
                                                                                          else high))))
        cells += [limits_text(about, name, unit) or "–", str(beyond) if limits else "–"]
        rows.append([escape(cell) for cell in (name, *cells)])
    return html_table(("metric", "least", "median", "largest", "limits", "beyond"), rows)


def worst_table(table: pa.Table, about: Mapping[str, Any], metrics: Sequence[tuple[str, str]], live: bool) -> str:
    """The samples that did worst, each with the command that flies it again, and its run in the live page."""
    why = why_not_live(about)
    linked = live and not why
    rows = []
    for sample, reason in worst(table, about, metrics):
        row = table.slice(sample, 1).to_pylist()[0]
        at = ", ".join(f"{each['name']} = {row[each['name']]:.5g}" for each in about["vary"])
        link = (f' <a href="{escape(live_link(about, row))}" aria-label="open it live: sample {sample}">open it live'
                "</a>") if linked else ""
        rows.append((str(sample), escape(reason), escape(at), f"<code>{escape(command_of(about, row))}</code> "
                     f'<button type="button" class="copy">Copy</button>{link}'))
    if not rows:
        return "<p>No sample failed.</p>"
    said = ("" if linked else f"<p>The live page cannot fly these: {escape(why)}.</p>" if why else
            f"<p>The live page can fly these: <code>maglev live</code> writes it, {LIVE_PAGE}; where that lies beside "
            "this page when this is written, each sample is linked to its run there.</p>")
    return html_table(("sample", "why", "at (SI)", "fly it again"), rows) + said


def worst(table: pa.Table, about: Mapping[str, Any], metrics: Sequence[tuple[str, str]]) -> list[tuple[int, str]]:
    """Numbers of the worst samples and why: not flown to their ends, failed, then the largest of each metric."""
    found: dict[int, str] = {}
    for sample, why in enumerate(table["failure"].to_pylist()):
        if why is not None:
            found.setdefault(sample, why)
    for sample, failed in enumerate(table["failed"].to_pylist()):
        if failed:
            found.setdefault(sample, "failed: a stop, a trip, or a large error at the end")
    limited = [item for item in metrics if item[0] in about["limits"]]
    for name, unit in limited or metrics:
        if name in ("trip time", "stop contact time"):   # of all others, less is better
            continue
        values = table[name].to_pylist()
        sample = max(range(len(values)), key=lambda i: -math.inf if values[i] is None else values[i])
        if values[sample] is not None:
            found.setdefault(sample, f"largest {name}: {metric_text(name, values[sample], unit)}")
    return list(found.items())[:MOST_WORST]


def indices_table(indices: Sequence[Indices]) -> str:
    """Sobol indices as numbers."""
    if not indices:
        return ""
    names = list(indices[0].first)
    rows = [(escape(each.metric), *(f"{values[name]:.2f} ± {sure[name]:.2f}" for name in names for values, sure in (
        (each.first, each.first_confidence), (each.total, each.total_confidence)))) for each in indices]
    heads = [f"{name}: {kind}" for name in names for kind in ("first", "total")]
    return ('<div id="sensitivity" class="plot" style="height:420px"></div>'
            "<details><summary>Numbers, with 95 % confidence</summary>"
            f"{html_table(('metric', *heads), rows)}</details>")
