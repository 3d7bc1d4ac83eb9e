"""Scenarios read from their files: those that come with the package by name, others by path; one run per variant."""

import hashlib
import json
from pathlib import Path

from maglev.files.errors import ScenarioError, nearest
from maglev.scenario.layers import (
    Layer,
    Scenario,
    ScenarioSource,
    is_packaged,
    merged,
    names_of_runs,
    packaged_files,
    packaged_runs,
    run_layers,
    scenario_of,
    scenario_source,
)
from maglev.scenario.run_plan import RunPlan


def load_plans(given: Scenario | ScenarioSource) -> list[RunPlan]:
    """Load a packaged scenario, or one run of it, by its bare name, or any other scenario by its path or its table.

    There is one run for each variant of the scenario, or the one that is named. ScenarioError if there is no such
    scenario or it has an error: one line with file, key, value and the expected values.
    """
    path, asked = scenario_source(given), ""
    if isinstance(path, Path) and path.name == str(given) and path.suffix != ".toml":
        asked, files = path.name, packaged_files()
        scenario = asked if asked in files else scenario_of(asked)
        if scenario is None:
            raise ScenarioError(f"there is no scenario {asked!r}; "
                                f"{nearest(asked, {**files, **packaged_runs()}, '.toml')}")
        path = files[scenario]
    runs = run_layers(path)
    names = names_of_runs(runs)
    return [read_plan(path, layers, names) for layers, name in zip(runs, names, strict=True)
            if asked not in names or name == asked]


def load_plan(given: Scenario) -> RunPlan:
    runs = load_plans(given)
    if len(runs) != 1:
        expected = "a scenario without" if runs[0]._own else f"one of {', '.join(run.name for run in runs)}"
        raise ScenarioError(f"{scenario_source(given)} has variants, expected {expected}")
    return runs[0]


def read_plan(path: ScenarioSource, layers: list[Layer], siblings: list[str]) -> RunPlan:
    """Return the plan of one run; `siblings` are the runs of its file."""
    plan = RunPlan.of_file(merged(layers), layers)
    named = [("claims.than", claim.than) for claim in plan.claims if claim.than is not None]
    named += [("claims.together_with", run) for claim in plan.claims for run in claim.together_with or ()]
    named += [("start_from.run", source) for source in sorted(plan.needs)]
    if plan.procedure is not None:
        named += [(f"procedure.runs.{part}", run) for part, run in plan.procedure.runs.items() if part != "parabolas"]
    for key, run in named:
        itself = plan.name if key == "start_from.run" else None
        if run == itself or (run not in siblings and scenario_of(run) is None):
            others = [name for name in (*siblings, *packaged_runs()) if name != itself]
            raise ScenarioError(f"{path}: {key} = {run!r}: expected another run; {nearest(run, others)}")
    if plan.procedure is not None and plan.procedure.name in siblings:
        raise ScenarioError(f"{path}: procedure.name = {plan.procedure.name!r}: a run has this name, expected another "
                            "one: results are named after it")
    plan._source, plan._own = path, not is_packaged(path)
    plan._sha256 = hashlib.sha256(json.dumps(merged(layers), default=str).encode("utf-8")).hexdigest()
    return plan
