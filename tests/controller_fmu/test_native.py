"""The native FMUs against the blocks they are made of, bit for bit."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from direct_loop import LAYOUTS
from estimator_run import PLACES, new_estimator
from fmu_access import bits, outputs, put, variables

from maglev.cosim.fmu import Fmu
from maglev.fmi.definition import reader


@pytest.mark.few(1)
@pytest.mark.parametrize("stage", [2, 3])
@pytest.mark.parametrize("parameters", [
    {}, {"matched_filter": True, "forgetting": 0.5}, {"epsilon": 0.001, "gamma": 3.0, "observer.time1": 0.0}])
def test_same_bits(trial: Callable[..., dict[str, np.ndarray]], load_native: Callable[[str], Fmu], stage: int,
                   parameters: dict[str, float]) -> None:
    axes, motors, dt = LAYOUTS[stage]
    data = trial(stage, seconds=20.0)
    fmu = load_native(f"Estimator{stage}DOF")
    fmu.initialise(parameters, 0.0, 10.0)
    starts = np.array([fmu.variable(f"C{i + 1}_start").start for i in range(stage + 2)], float)
    block = new_estimator(stage, starts, **parameters)
    names = [v.name for v in variables(fmu, "output")]
    values_of = reader([PLACES[stage][name] for name in names])
    for k in range(600):
        inputs = {f"{name}.measured": float(data[f"{name}.encoder"][15_000 + k]) for name in axes}
        inputs |= {f"{name}.{what}": float(data[f"{name}.{what}"][15_000 + k])
                   for name in motors for what in ("i_d", "i_q")}
        put(fmu, inputs)
        for name, value in inputs.items():
            owner, _, what = name.partition(".")
            setattr(getattr(block, owner), what, value)
        fmu.instance.doStep(k * dt, dt)
        assert block.step(k * dt, dt) == 0
        ours = dict(zip(names, values_of(block), strict=True))
        assert bits([outputs(fmu)]) == bits([ours]), k


@pytest.mark.parametrize("weight", [1e-20, 1e-18, 1e-12])
def test_the_smallest_weights(load_either: Callable[[str], Fmu], weight: float) -> None:
    """With which an undamped error goes through more turns in a sample than an angle keeps digits of."""
    fmu = load_either("Estimator2DOF")
    fmu.initialise({"gamma": 1.0, "epsilon": 1e-3, "C1_weight": weight}, 0.0, 10.0)
    put(fmu, {"motor.i_q": 1000.0, "h.measured": 1e-3})
    fmu.instance.doStep(0.0, 5e-4)
    assert all(map(math.isfinite, outputs(fmu).values()))
