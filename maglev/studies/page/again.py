"""What a sample of a study flies, and the command that flies it again as a full run."""

import shlex
from collections.abc import Mapping
from typing import Any

from maglev.errors import ScenarioError

# The options of `maglev run` by those of Python: what a study was flown with is kept by these.
FLAGS = {"model": "--model", "plant": "--plant", "controller": "--controller", "ports": "--map", "step": "--step",
         "order": "--order", "fmus": "--fmus", "native": "--native", "fmi": "--fmi",
         "keep_settings": "--keep-settings"}


def run_of(about: Mapping[str, Any]) -> Mapping[str, Any]:
    """What a dataset says of the run that is flown; ScenarioError if of a version that had only its words."""
    run = about["run"]
    if not isinstance(run, Mapping):
        raise ScenarioError(f"{about['name']}: run = {shlex.join(run)!r} of an earlier version, expected a dataset of "
                            "this one: fly the study again")
    return run


def values_of(about: Mapping[str, Any], row: Mapping[str, Any]) -> dict[str, Any]:
    """What the run of a row of the dataset sets: values, SI, by `fmu.variable` or reference."""
    columns = {target: each["name"] for each in about["vary"] for target in each["set"]}
    return {**run_of(about)["set"], **{target: row[target] if target in row else row[columns[target]]
                                      for target in about["targets"]}}


def command_of(about: Mapping[str, Any], row: Mapping[str, Any]) -> str:
    """Command for a row of the dataset; its numbers are written such that they are the same bits."""
    run = run_of(about)
    words = ["maglev", "run", run["scenario"]]
    for key, value in run["options"].items():
        words += [FLAGS[key]] if value is True else [FLAGS[key], value]
    for target, value in values_of(about, row).items():
        words += ["--set", f"{target}={str(value).lower() if isinstance(value, bool) else repr(value)}"]
    return shlex.join(words)
