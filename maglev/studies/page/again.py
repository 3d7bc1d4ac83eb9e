"""The command that flies a sample of a study again, as a full run."""

import shlex
from collections.abc import Mapping
from typing import Any


def values_of(about: Mapping[str, Any], row: Mapping[str, Any]) -> dict[str, Any]:
    """What a row of the dataset sets: values, SI, by `fmu.variable` or reference."""
    columns = {target: each["name"] for each in about["vary"] for target in each["set"]}
    return {target: row[target] if target in row else row[columns[target]] for target in about["targets"]}


def command_of(about: Mapping[str, Any], row: Mapping[str, Any]) -> str:
    """Command for a row of the dataset; its numbers are written such that they are the same bits."""
    words = list(about["run"])
    for target, value in values_of(about, row).items():
        words += ["--set", f"{target}={str(value).lower() if isinstance(value, bool) else repr(value)}"]
    return shlex.join(words)
