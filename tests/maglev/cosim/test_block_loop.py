"""Loops with the FMUs' blocks: their C is that of the scenario, and so it is compiled once."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from maglev.cosim import block_loop
from maglev.cosim.master import Observer
from maglev.many.measuring import Measuring
from maglev.many.repeated_run import RepeatedRun
from maglev.runs.preparation import prepare
from maglev.scenario.loading import load_plan

ARENA = 10_000_000


def upwards_or_downwards(step: int) -> Callable[..., Any]:
    """Allocate rows one after the other, or each before the last."""
    arena, place = np.zeros(ARENA, np.uint8), [0 if step > 0 else ARENA]

    def allocate(_: object, shape: tuple[int, int], kind: type) -> Any:
        size = -(-shape[0] * shape[1] * np.dtype(kind).itemsize // 64) * 64
        first = place[0] if step > 0 else place[0] - size
        place[0] += step * size
        return arena[first:first + size].view(kind)[:shape[0] * shape[1]].reshape(shape)

    return allocate


def test_its_c_is_the_same_wherever_memory_lies(native_fmus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The platform is fed by its controller and by signals: which is set first is no matter of addresses."""
    taken: list[dict[str, str]] = []
    monkeypatch.setattr(block_loop, "loop_of", lambda sources, _: taken.append(sources))
    experiment = prepare(load_plan("3dof-push"), native_fmus, {}, {})
    for step in (1, -1):
        monkeypatch.setattr(Observer, "allocate", upwards_or_downwards(step))
        with RepeatedRun(experiment, measuring=Measuring(experiment.plan, experiment.times)) as trial:
            trial.load()
    assert taken[0] == taken[1]
