"""An estimator block over a run, sample by sample."""

from typing import Any

import numpy as np
from direct_loop import LAYOUTS
from named_controllers import Estimator2DOF, Estimator3DOF

from maglev.descriptions.own_fmus import definition
from maglev.fmi.definition import reader, write

# Constants of the controllers' model, which an ideal stage has.
TRUTH = {2: np.array([14.20, 796.99, 31.04, 0.07]), 3: np.array([0.6135, 0.8224, 327.50, 8.48, 0.0070])}

# Attribute paths of variables, by their FMI names.
PLACES = {stage: {v.name: v.place for v in definition(f"Estimator{stage}DOF").variables} for stage in TRUTH}

# The observer reads the mean velocity of the last sample: with exact encoders that is as good as the true one.
TRUE_VELOCITY = {"observer.time1": 0.0, "observer.time2": 0.0}


def new_estimator(stage: int, starts: np.ndarray, **parameters: float) -> Any:
    """Estimator that starts at given estimates; parameters by their FMI names."""
    estimator: Any = Estimator2DOF() if stage == 2 else Estimator3DOF()
    names = {f"C{i + 1}_start": float(value) for i, value in enumerate(starts)}
    for name, value in (names | parameters).items():
        write(estimator, PLACES[stage][name], value)
    assert estimator.start() == 0
    return estimator


def constants(stage: int, estimator: Any) -> tuple[float, ...]:
    """Estimates as they are."""
    return reader([PLACES[stage][f"C{i + 1}"] for i in range(len(TRUTH[stage]))])(estimator)


def run(stage: int, estimator: Any, trial: dict[str, np.ndarray], measured: str = "encoder") -> np.ndarray:
    """Estimates after every sample, shape (samples, constants)."""
    axes, motors, dt = LAYOUTS[stage]
    wires = [(getattr(estimator, name), "measured", trial[f"{name}.{measured}"].tolist()) for name in axes]
    wires += [(getattr(estimator, name), what, trial[f"{name}.{what}"].tolist())
              for name in motors for what in ("i_d", "i_q")]
    estimates = []
    for k in range(len(trial["time"])):
        for owner, what, values in wires:
            setattr(owner, what, values[k])
        assert estimator.step(k * dt, dt) == 0
        estimates.append(constants(stage, estimator))
    return np.array(estimates)
