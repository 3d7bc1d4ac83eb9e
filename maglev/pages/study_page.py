"""The page of a study: where it holds and breaks, metrics, Sobol indices, every sample, and the worst."""

import math
from base64 import b64encode
from collections.abc import Mapping, Sequence
from functools import partial
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
import pyarrow as pa

from maglev.files.arrays import Array
from maglev.files.errors import lacking
from maglev.many.study_columns import OF_EVERY_RUN
from maglev.pages import shell
from maglev.pages.findings import html_table, typeset
from maglev.pages.live_content import NAME as LIVE_PAGE
from maglev.pages.live_content import live_address
from maglev.pages.outcome_map import OUTCOMES, LawMap, map_of, maps_data
from maglev.pages.report_page import STYLE, json_in_html, read
from maglev.pages.sample_commands import command_of, row_link, settings_of_sample, why_no_replay
from maglev.pages.study_text import QUANTILES, beyond_limits, counted, limits_text, metrics_of, quantiles, units_of
from maglev.pages.study_verdict import answer, decisive_metric, question, study_verdict, telling, where
from maglev.pages.varied import varied_of
from maglev.runs.endings import COMPLETED, cause, severity
from maglev.scenario.quantities import metric_text, shown_in

own_text = partial(shell.read, folder=Path(__file__).with_name("study"))
SERIES = "plots/series.js"   # of the report
OWN = ("study.html", "study.css", "map.js", "parallel.js", "study.js")
MOST_DRAWN = 4096   # samples that are drawn: a page of 10⁵ would be as large as its dataset
MOST_WORST = 10     # samples that are listed


def write_page(path: Path, table: pa.Table, about: Mapping[str, Any]) -> None:
    """Write the page of a study, which needs no network."""
    shell.publish(path, study_page(table, about, path.with_name(LIVE_PAGE).is_file()))


def study_page(table: pa.Table, about: Mapping[str, Any], live: bool = False) -> str:
    """Text of the page; `live` is whether the live page lies next to it."""
    count = table.num_rows
    drawn = np.unique(np.linspace(0, count - 1, min(count, MOST_DRAWN)).astype(int))
    metrics = [(name, unit) for name, unit, values in metrics_of(table) if varies(values)]
    provenance, mapped = about["provenance"], map_of(table, about)
    # The share of samples that pass is seen in the map, where there is one.
    shares = count > 1 and not mapped and not all(table["passed"].to_pylist())
    shown = data(table, about, metrics, drawn, shares, mapped) | {"card": card_data(table, about, drawn, live)}
    html, css, *own = map(own_text, OWN)
    passing, reasons = answer(table, about)
    return shell.page(
        "study", f"{escape(about['name'])}: a study", typeset(f"{passing}{reasons} {question(table, about)}"),
        STYLE + css, html,
        name=escape(about["name"]), subject=escape(about["title"]), description=escape(about["description"]),
        design=f"Scenario {escape(about['scenario'])}; {design_text(about)}."
               + (f" Drawn are {len(drawn):,} samples." if len(drawn) < count else ""),
        verdict=study_verdict(table, about), where=where(table, about),
        heading="Where it holds, and where it breaks" if 0 < sum(table["passed"].to_pylist()) < count else
                "What it changes" if count > 1 else "What was run",
        maps='<div id="maps"></div>' if mapped else "",
        responses=responses(shown) if metrics or shares else "",
        metrics=quantiles_table(table, about),
        parallel=own_text("parallel.html").rstrip() if metrics else "",
        sensitivity=sensitivity_section(table, about) if about["design"]["kind"] == "saltelli" else "",
        worst=worst_table(table, about, metrics, live),
        provenance=f"maglev-fmus {escape(provenance['version'])}"
                   + (f", commit {escape(provenance['commit'])}" if provenance["commit"] else "")
                   + f", Python {escape(provenance['python'])}; "
                   + "; ".join(f"{escape(fmu['name'])}: {escape(Path(fmu['file']).name)} ({escape(fmu['kind'])})"
                               for fmu in provenance["fmus"])
                   + "".join(f"; {escape(change)}" for change in provenance["changes"]),
        data=json_in_html({**shown, **({"maps": maps_data([mapped], OUTCOMES)} if mapped else {})}),
        scripts=shell.scripts(read(SERIES), *own))


def write_maps(path: Path, title: str, said: str, maps: Sequence[LawMap], words: Sequence[str] = OUTCOMES) -> None:
    """Write a page of the maps of some laws, side by side, with a sentence about them, and words for `OUTCOMES`."""
    shell.publish(path, shell.page(
        "study", escape(title), escape(said), STYLE + own_text("study.css"), own_text("maps.html"),
        name=escape(title), said=escape(said), data=json_in_html({"maps": maps_data(maps, words)}),
        scripts=shell.scripts(read(SERIES), own_text("map.js"))))


def varies(values: Array) -> bool:
    """Return True if a metric differs between samples, so that it is worth a plot."""
    return len(values) > 0 and values.min() != values.max()


def design_text(about: Mapping[str, Any]) -> str:
    """The design in words."""
    design = about["design"]
    if design["kind"] == "grid":
        return "every combination of the values"
    if design["kind"] == "rows":
        return "the values row by row"
    return f"design: {design['kind']}, {counted(design['samples'])}, seed {design['seed']}"


def data(table: pa.Table, about: Mapping[str, Any], metrics: Sequence[tuple[str, str]],
         drawn: np.ndarray[Any, np.dtype[np.intp]], shares: bool,
         mapped: LawMap | None) -> dict[str, Any]:
    """Return the data of the page's script: columns in one unit each, the first one shown, and whether shares pass.

    The varied quantities to the right and upwards in the map are in it, if there is one.
    """
    chosen = table.take(pa.array(drawn))
    units = units_of(table)
    every = varied_of(chosen, about)
    varied = [each.name for each in every]
    names = [*varied, *(name for name, _ in metrics)]
    columns = [{"name": each.label, "unit": each.unit, "limits": {}, **({"signed": True} if each.signed else {}), **(
        {"of": each.name, "scale": each.scale} if each.name in about["targets"] and not each.signed else
        {"values": [float(f"{value:.6g}") for value in each.values.tolist()]})} for each in every]
    for name, _ in metrics:
        known = [value for value in table[name].to_pylist() if value is not None]
        unit, scale = shown_in(known, units[name])
        limits = {key: scale * value for key, value in about["limits"].get(name, {}).items() if value is not None}
        columns.append({"name": name, "unit": unit, "limits": limits, "values": [
            None if value is None or not math.isfinite(value) else float(f"{scale * value:.5g}")
            for value in chosen[name].to_pylist()]})
    sides = [factor.name for factor in mapped.factors[1::-1]] if mapped else telling(table, about)
    first, second, *_ = [varied.index(name) for name in sides] * 2
    metric = decisive_metric(table, about)
    causes = [*map(cause, chosen["ending"].to_pylist())]
    kinds = [*dict.fromkeys(causes)]
    # The metric that fails, or in cells of several samples the share of those that pass; crosses say which of one fail.
    by_cell = shares and about["design"]["kind"] == "grid" and len(varied) > 2
    if not any(chosen["passed"].to_pylist()):   # how far each is from its limit
        second = first
    begin = (names.index(metric) if metric in names else -1 if by_cell or not metrics else
             next((k for k, name in enumerate(names) if k >= len(varied) and name not in OF_EVERY_RUN), len(varied)))
    some = {"samples": drawn.tolist()} if len(drawn) < table.num_rows else {}
    return {**some, "varied": len(varied), "columns": columns, "begin": [begin, first, second], "shares": shares,
            "grid": about["design"]["kind"] == "grid",
            "passed": "".join(str(int(passed)) for passed in chosen["passed"].to_pylist()),
            "causes": kinds, "cause": [kinds.index(said) for said in causes]}


def card_data(table: pa.Table, about: Mapping[str, Any], drawn: np.ndarray[Any, np.dtype[np.intp]],
              live: bool) -> dict[str, Any]:
    """Return what runs a sample again: the command, the address in the live page, and the values that it sets, SI."""
    rows = [settings_of_sample(about, row) for row in table.take(pa.array(drawn)).to_pylist()]
    fixed = {target: value for target, value in about["run"]["set"].items() if target not in about["targets"]}
    linked = live and not why_no_replay(about)
    columns: dict[tuple[float | bool, ...], list[str]] = {}   # what is set to the same values
    for target in about["targets"]:
        columns.setdefault(tuple(row[target] for row in rows), []).append(target)
    return {"command": command_of(about, None), "live": live_address(about["scenario"], fixed) if linked else "",
            "sets": [{"targets": targets, **exact(values)} for values, targets in columns.items()]}


def exact(values: Sequence[float | bool]) -> dict[str, Any]:
    """Return values for the script, with all their bits: each once and where it stands, or as bytes where most differ.
    """
    levels, at = np.unique(np.array(values), return_inverse=True)
    if 2 * len(levels) < len(values) or levels.dtype != np.float64:
        return {"levels": levels.tolist(), "at": at.tolist()}
    return {"bytes": b64encode(np.array(values, "<f8").tobytes()).decode()}


def responses(shown: Mapping[str, Any]) -> str:
    """Place of the plot of a metric over what varies, with the choices: nothing moves when the script begins."""
    names, varied = [column["name"] for column in shown["columns"]], shown["varied"]
    over = dict(enumerate(names[:varied]))
    metrics = ({-1: "samples that pass"} if shown["shares"] else {}) | {k: names[k] for k in range(varied, len(names))}
    choices = {name: "".join(f'<option value="{k}"{" selected" * (k == chosen)}>{escape(text)}</option>'
                             for k, text in options.items())
               for name, options, chosen in zip(("metric", "first", "second"), (metrics, over, over), shown["begin"],
                                                strict=True)}
    return Template(own_text("responses.html").rstrip()).substitute(choices, hidden="" if varied > 1 else " hidden")


def quantiles_table(table: pa.Table, about: Mapping[str, Any]) -> str:
    """Return the least, median and largest value of every metric: first of those with limits, with counts beyond.

    The others are folded then; an event that never happened in any sample is left out.
    """
    limited, others, heads = [], [], QUANTILES if table.num_rows > 1 else ("metric", "value")
    for name, unit, values in metrics_of(table):
        if len(values) and (varies(values) or name not in OF_EVERY_RUN):
            cells = [*map(typeset, quantiles(name, unit, values))][:len(heads)]
            if name in about["limits"]:
                limited.append([*cells, typeset(limits_text(about, name, unit)),
                                str(beyond_limits(values, about, name).sum())])
            else:
                others.append(cells)
    every = html_table(heads, others, look="cards numbers") if others else ""
    if not limited:
        return every
    return html_table((*heads, "limits", "samples outside"), limited, look="cards numbers") + (
        f"<details><summary>Metrics without limits</summary>{every}</details>" if every else "")


def worst_table(table: pa.Table, about: Mapping[str, Any], metrics: Sequence[tuple[str, str]], live: bool) -> str:
    """The samples that did worst, each with the command that runs it again, and its run in the live page."""
    why = why_no_replay(about)
    varied = varied_of(table, about)
    linked = live and not why
    rows = []
    for sample, reason in worst(table, about, metrics):
        row = table.slice(sample, 1).to_pylist()[0]
        at = ", ".join(f"{each.label} = {each.text(each.values[sample], digits=5)}" for each in varied)
        link = (f' <a class="screen" href="{escape(row_link(about, row))}" aria-label="open it live: sample {sample}">'
                "open it live</a>") if linked else ""
        rows.append((str(sample), typeset(reason), typeset(at),
                     f"<code>{escape(command_of(about, row))}</code> "
                     f'<button type="button" class="copy">Copy</button>{link}'))
    if not rows:
        return ""
    said = ("" if linked else f"<p>The live page cannot run these: {escape(why)}.</p>" if why else
            f"<p>The live page can run these: write {LIVE_PAGE} into this folder with <code>maglev live</code>, then "
            "write this page again. It then links each sample to its run there.</p>")
    listed = html_table(("sample", "why", "at", "run it again"), rows, look="cards")
    heading = "Worst samples" if table.num_rows > 1 else "The sample"
    return f'<section class="worst"><h2>{heading}</h2>{listed}{said}</section>'


def worst(table: pa.Table, about: Mapping[str, Any], metrics: Sequence[tuple[str, str]]) -> list[tuple[int, str]]:
    """Numbers of the worst samples and why: how they ended if not well, then the largest of each metric."""
    if table.num_rows == 1:
        return [(0, table["ending"][0].as_py())]
    ends = sorted(enumerate(table["ending"].to_pylist()), key=lambda item: severity(item[1]))
    reasons = {sample: said for sample, said in ends if said != COMPLETED}
    limited = [item for item in metrics if item[0] in about["limits"]]
    for name, unit in limited or metrics:
        if name in ("trip time", "stop contact time"):   # of all others, less is better
            continue
        values = table[name].to_pylist()
        sample = max(range(len(values)), key=lambda i: -math.inf if values[i] is None else values[i])
        if values[sample] is not None:
            reasons.setdefault(sample, f"largest {name}: {metric_text(name, values[sample], unit)}")
    return list(reasons.items())[:MOST_WORST]


def sensitivity_section(table: pa.Table, about: Mapping[str, Any]) -> str:
    """Return Sobol indices as numbers over bars, and the metrics without any; empty if there is nothing to show."""
    indices, notes = sensitivity(table, about)
    if not indices and not notes:
        return ""
    said = "\n".join(f"<p>{escape(note)}</p>" for note in notes)
    if indices:
        rows = [(escape(metric), *(
            f'<span class="share" style="--share: {100.0 * at:.0f}%">{at:.2f} ± {sure:.2f}</span>'
            for k in range(len(about["vary"])) for at, sure in ((of["S1"][k], of["S1_conf"][k]),
                                                                (of["ST"][k], of["ST_conf"][k]))))
                for metric, of in indices.items()]
        heads = [f"{parameter['name']}: {kind}" for parameter in about["vary"] for kind in ("first", "total")]
        said += ("<p>Sobol indices, with 95 % confidence: the share of a metric's variance that a quantity causes by "
                 f"itself (first), and together with others (total).</p>{html_table(('metric', *heads), rows)}")
    return f"<section><h2>Sensitivity</h2>{said}</section>"


def sensitivity(table: pa.Table, about: Mapping[str, Any]) -> tuple[dict[str, Mapping[str, Array]], list[str]]:
    """Return indices S1, ST, computed by SALib, of every metric that has some, and sentences on why others have none.

    Each has the shape (varied quantities,), as have their 95 % confidences S1_conf, ST_conf.
    """
    if about["correlated"]:
        return {}, ["Sobol indices need independent quantities; some are correlated."]
    if any(why is not None for why in table["failure"].to_pylist()):
        return {}, ["Sobol indices need every sample; some were not completed."]
    if missing := lacking("SALib", "study", "a Sobol index"):
        return {}, [f"{missing}."]
    from SALib.analyze import sobol

    names = [parameter["name"] for parameter in about["vary"]]
    problem = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
    computed, constant, endless = dict[str, Mapping[str, Array]](), [], []
    for name, _, values in metrics_of(table):
        if len(values) < table.num_rows or not np.isfinite(values).all():
            endless.append(name)
        elif values.min() == values.max():
            constant.append(name)
        else:
            # SALib draws its resamples from NumPy's generator of that seed: the same page for the same study.
            computed[name] = sobol.analyze(problem, values, calc_second_order=False, seed=about["design"]["seed"])
    notes = []
    if endless:
        notes.append(f"None of {', '.join(endless)}: not finite in every sample, such as a band in which one never "
                     "settled.")
    if constant:
        notes.append(f"None of {', '.join(constant)}: the same in every sample.")
    return computed, notes
