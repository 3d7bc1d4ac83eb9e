"""A sample of a study as a full run: its command, and its address in the live page, or why it has none."""

import shlex
from collections.abc import Mapping
from typing import Any

from maglev.descriptions.own_fmus import DEFINITIONS, definition
from maglev.pages.live_content import can_run_live, live_address
from maglev.scenario.layers import scenario_of
from maglev.scenario.loading import load_plan
from maglev.scenario.options import OPTIONS


def settings_of_sample(about: Mapping[str, Any], row: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of a row of the dataset: values, SI, by `fmu.variable` or reference."""
    columns = {target: parameter["name"] for parameter in about["vary"] for target in parameter["set"]}
    return {**about["run"]["set"],
            **{target: row[target if target in row else columns[target]] for target in about["targets"]}}


def row_options(about: Mapping[str, Any], row: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of `maglev.run` for a row of the dataset."""
    run = about["run"]
    options = {key: int(value) if key == "fmi" else value for key, value in run["options"].items()}
    return {"name": run["scenario"], **options, "set": settings_of_sample(about, row)}


def command_of(about: Mapping[str, Any], row: Mapping[str, Any] | None) -> str:
    """Return the command for a row of the dataset, with the same bits; without a row, with the settings of all."""
    run = about["run"]
    words = ["maglev", "run", run["scenario"]]
    for key, value in run["options"].items():
        words += [OPTIONS[key].flag] if value is True else [OPTIONS[key].flag, value]
    for target, value in (run["set"] if row is None else settings_of_sample(about, row)).items():
        words += ["--set", f"{target}={str(value).lower() if isinstance(value, bool) else repr(value)}"]
    return shlex.join(words)


def why_no_replay(about: Mapping[str, Any]) -> str:
    """Return why the live page cannot run the samples of a study in the same way; empty if it can."""
    name, run = about["scenario"], about["run"]
    if run["scenario"] != name or scenario_of(name) is None:
        return f"it has the packaged runs only, not {name}"
    plan = load_plan(name)
    if not can_run_live(plan):
        return f"it does not have {name}"
    for key in run["options"]:
        if not OPTIONS[key].same_results:
            return ("it has its own plants, controllers and steps, and this study ran with "
                    f"{OPTIONS[key].flag}")
    for target in [*about["targets"], *run["set"]]:
        fmu, _, variable = target.partition(".")
        model = plan.fmus[fmu].model if fmu in plan.fmus else None
        known = {v.name for v in definition(model).variables if v.causality == "parameter"} \
            if model in DEFINITIONS else set()
        if variable not in known:
            return f"it sets parameters of plant and controller only, and the samples differ in {target}"
    return ""


def row_link(about: Mapping[str, Any], row: Mapping[str, Any]) -> str:
    """Address that opens a row of the dataset in the live page."""
    return live_address(about["scenario"], settings_of_sample(about, row))
