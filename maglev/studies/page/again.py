"""What a sample of a study flies, and the command that flies it again as a full run."""

import shlex
from collections.abc import Mapping
from typing import Any

# The options of `maglev run` by those of Python: what a study was flown with is kept by these.
FLAGS = {"model": "--model", "plant": "--plant", "controller": "--controller", "ports": "--map", "step": "--step",
         "order": "--order", "fmus": "--fmus", "native": "--native", "fmi": "--fmi",
         "keep_settings": "--keep-settings"}


def values_of(about: Mapping[str, Any], row: Mapping[str, Any]) -> dict[str, Any]:
    """What the run of a row of the dataset sets: values, SI, by `fmu.variable` or reference."""
    columns = {target: each["name"] for each in about["vary"] for target in each["set"]}
    return {**about["run"]["set"], **{target: row[target] if target in row else row[columns[target]]
                                      for target in about["targets"]}}


def command_of(about: Mapping[str, Any], row: Mapping[str, Any]) -> str:
    """Command for a row of the dataset; its numbers are written such that they are the same bits."""
    words = ["maglev", "run", about["run"]["scenario"]]
    for key, value in about["run"]["options"].items():
        words += [FLAGS[key]] if value is True else [FLAGS[key], value]
    for target, value in values_of(about, row).items():
        words += ["--set", f"{target}={str(value).lower() if isinstance(value, bool) else repr(value)}"]
    return shlex.join(words)
