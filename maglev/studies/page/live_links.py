"""Links of a study's samples to the live page, where that can fly exactly these runs; otherwise why it cannot."""

from collections.abc import Mapping
from typing import Any

from maglev.live.content import flies_live
from maglev.live.link import live_address
from maglev.own_fmus import DEFINITIONS, definition
from maglev.schema.layers import packaged_runs
from maglev.schema.loading import load_plan
from maglev.studies.page.again import values_of
from maglev.units import number_or_text, parse_quantity

# Of the command that flew the study: the kinds of FMU agree bit for bit, wherever the files are.
HARMLESS = {"--native": 0, "--fmus": 1}


def why_not_live(about: Mapping[str, Any]) -> str:
    """Why the live page cannot fly the samples of a study as they were flown; empty if it can."""
    words = list(about["run"])
    name = about["scenario"]
    if words[2] != name or name not in packaged_runs():
        return f"it has the packaged runs alone, and {name} is none of these"
    plan = load_plan(name)
    if not flies_live(plan):
        return f"it does not have {name}"
    k = 3
    while k < len(words):
        if words[k] != "--set" and words[k] not in HARMLESS:
            return f"it has its own plants and controllers and their steps, and this study was flown with {words[k]}"
        k += 1 + HARMLESS.get(words[k], 1)
    for target in [*about["targets"], *(setting.partition("=")[0] for setting in settings(words))]:
        fmu, _, variable = target.partition(".")
        model = plan.fmus[fmu].model if fmu in plan.fmus else None
        known = {v.name for v in definition(model).variables if v.causality == "parameter"} \
            if model in DEFINITIONS else set()
        if variable not in known:
            return f"it sets parameters of the plant and the controller alone, and the samples differ in {target}"
    return ""


def live_link(about: Mapping[str, Any], row: Mapping[str, Any]) -> str:
    """Address that opens a row of the dataset in the live page."""
    fixed = dict(setting.split("=", 1) for setting in settings(about["run"]))
    return live_address(about["scenario"], {name: si_value(text) for name, text in fixed.items()}
                        | values_of(about, row))


def settings(words: list[str]) -> list[str]:
    """What a command sets, each `fmu.variable=value`."""
    return [value for flag, value in zip(words, words[1:], strict=False) if flag == "--set"]


def si_value(text: str) -> float | bool:
    """A value of a command, with or without a unit."""
    return text == "true" if text in ("true", "false") else parse_quantity(number_or_text(text))
