"""Scenarios read from their files: those that come with the package by name, others by path; one run per variant."""

from functools import cache
from pathlib import Path

from pydantic import ValidationError

from maglev.errors import ScenarioError, nearest
from maglev.schema.scenario import Scenario
from maglev.schema.toml_table import PACKAGED, RIGS, Layer, extended, merged, one_line, read_layers


@cache
def packaged_files() -> dict[str, Path]:
    """Files of the scenarios that come with the package, by name, in the order of these."""
    return {path.stem: path for rig in RIGS for path in sorted((PACKAGED / rig).glob("*.toml"), key=lambda p: p.stem)}


def packaged_scenarios() -> list[str]:
    """Return the names of the scenarios that come with the package."""
    return list(packaged_files())


@cache
def packaged_runs() -> dict[str, str]:
    """Names of all runs that come with the package, one for each variant, and the scenarios that they belong to."""
    return {run: name for name in packaged_scenarios() for run in runs_in(read_layers(packaged_files()[name]))}


def runs_in(layers: list[Layer]) -> list[str]:
    """Names of the runs that a scenario file defines."""
    table = merged(layers)
    variants = table.get("variants")
    names = [f"{table.get('name')}-{variant}" for variant in variants] if isinstance(variants, dict) else []
    return names or [str(table.get("name"))]


def load_runs(name_or_path: str | Path) -> list[Scenario]:
    """Load a packaged scenario, or one run of it, by its bare name, or any other scenario by its path.

    Returns
    -------
    list of Scenario
        One run for each variant of the scenario, or the one that is named.

    Raises
    ------
    ScenarioError
        If there is no such scenario, or something in it is not as expected; one line with file, key, value and
        what was expected.
    """
    path = Path(name_or_path)
    if path.name == str(name_or_path) and path.suffix != ".toml":
        names = {name: name for name in packaged_scenarios()} | packaged_runs()
        if path.name not in names:
            raise ScenarioError(f"there is no scenario {path.name!r}; nearest is {nearest(path.name, names)}")
        runs = read_runs(packaged_files()[names[path.name]])
        return [run for run in runs if run.name == path.name] or runs
    return read_runs(path)


def load_scenario(name_or_path: str | Path) -> Scenario:
    """Load a single run; see `load_runs`."""
    runs = load_runs(name_or_path)
    if len(runs) != 1:
        raise ScenarioError(f"{name_or_path} has variants, expected one of {', '.join(run.name for run in runs)}")
    return runs[0]


def read_runs(path: Path) -> list[Scenario]:
    """Runs of a scenario file: one for each entry of its table `variants`, or the scenario itself.

    A variant is merged over the scenario; its claims come after the scenario's own.
    """
    layers = read_layers(path)
    table = merged(layers)
    variants = table.get("variants", {})
    if not isinstance(variants, dict) or not all(isinstance(variant, dict) for variant in variants.values()):
        raise ScenarioError(f"{path}: variants = {variants!r}: expected tables, one for each variant")
    base = [Layer(layer.path, {key: value for key, value in layer.table.items() if key != "variants"})
            for layer in layers]
    if not variants:
        return [read_run(path, base, runs_in(layers))]
    runs = []
    for name, variant in variants.items():
        claims = [*table.get("claims", []), *variant.get("claims", [])]
        over = {**variant, "name": f"{table.get('name')}-{name}", "claims": claims}
        runs.append(read_run(path, [*base, *extended(Layer(path, over))], runs_in(layers)))
    return runs


def read_run(path: Path, layers: list[Layer], siblings: list[str]) -> Scenario:
    """Scenario of one run; `siblings` are the runs of its file."""
    try:
        scenario = Scenario.model_validate(merged(layers))
    except ValidationError as error:
        raise ScenarioError(one_line(error, layers)) from None
    for claim in scenario.claims:
        if claim.than is not None and claim.than not in siblings and claim.than not in packaged_runs():
            raise ScenarioError(f"{path}: claims.than = {claim.than!r}: there is no such run; nearest is "
                                f"{nearest(claim.than, [*siblings, *packaged_runs()])}")
    for source in sorted(scenario.needs):
        if source == scenario.name or (source not in siblings and source not in packaged_runs()):
            raise ScenarioError(f"{path}: start_from.run = {source!r}: expected another run; nearest is "
                                f"{nearest(source, [*siblings, *packaged_runs()])}")
    for part, name in (scenario.procedure.runs if scenario.procedure is not None else {}).items():
        if part != "parabolas" and name not in siblings and name not in packaged_runs():
            raise ScenarioError(f"{path}: procedure.runs.{part} = {name!r}: there is no such run; nearest is "
                                f"{nearest(name, [*siblings, *packaged_runs()])}")
    if scenario.procedure is not None and scenario.procedure.name in siblings:
        raise ScenarioError(f"{path}: procedure.name = {scenario.procedure.name!r}: a run is called so, expected "
                            "another name, for the results are named after it")
    scenario._path = path
    return scenario
