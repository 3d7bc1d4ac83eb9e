"""A study to begin with, as a file."""

from pathlib import Path

from maglev.errors import ScenarioError, key_path
from maglev.own_stage.new import seen_from, toml_file, write_new
from maglev.rig.writer import render
from maglev.schema.loading import load_plan


def new_study(path: str | Path, scenario: str | Path) -> Path:
    """Write a study that runs, to begin with; nothing is overwritten.

    Parameters
    ----------
    path : path
        The file, NAME or NAME.toml; its results are named after it.
    scenario : str or path
        What it runs: a run of the package by its name, or a scenario of yours, without variants.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    RigError, ScenarioError
        If the file is there already, its name is none, or there is no such scenario, or none about a stage.

    Examples
    --------
    >>> import maglev
    >>> maglev.new_study("robust.toml", "2dof-setpoints").name
    'robust.toml'
    """
    file, plan = toml_file(path), load_plan(scenario)
    if plan.rig is None or "plant" not in plan.fmus:
        raise ScenarioError(f"{scenario}: fmus = {key_path(list(plan.fmus))}: expected a scenario with the plant of a "
                            "stage")
    name = seen_from(file, scenario) if str(scenario).endswith(".toml") else str(scenario)
    write_new(file, render("new/study.toml.j2", plan.rig, file=file.name, name=file.stem, scenario=name))
    return file
