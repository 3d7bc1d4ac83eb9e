"""Links of a study's samples to the live page, where that can fly exactly these runs; otherwise why it cannot."""

from collections.abc import Mapping
from typing import Any

from maglev.live.content import flies_live
from maglev.live.link import live_address
from maglev.own_fmus import DEFINITIONS, definition
from maglev.schema.layers import packaged_runs
from maglev.schema.loading import load_plan
from maglev.studies.page.again import FLAGS, run_of, values_of

HARMLESS = ("native", "fmi", "fmus")   # the kinds of FMU agree bit for bit, wherever the files are


def why_not_live(about: Mapping[str, Any]) -> str:
    """Why the live page cannot fly the samples of a study as they were flown; empty if it can."""
    name, run = about["scenario"], run_of(about)
    if run["scenario"] != name or name not in packaged_runs():
        return f"it has the packaged runs alone, and {name} is none of these"
    plan = load_plan(name)
    if not flies_live(plan):
        return f"it does not have {name}"
    for key in run["options"]:
        if key not in HARMLESS:
            return f"it has its own plants and controllers and their steps, and this study was flown with {FLAGS[key]}"
    for target in [*about["targets"], *run["set"]]:
        fmu, _, variable = target.partition(".")
        model = plan.fmus[fmu].model if fmu in plan.fmus else None
        known = {v.name for v in definition(model).variables if v.causality == "parameter"} \
            if model in DEFINITIONS else set()
        if variable not in known:
            return f"it sets parameters of the plant and the controller alone, and the samples differ in {target}"
    return ""


def live_link(about: Mapping[str, Any], row: Mapping[str, Any]) -> str:
    """Address that opens a row of the dataset in the live page."""
    return live_address(about["scenario"], values_of(about, row))
