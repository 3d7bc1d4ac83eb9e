"""Estimates against the constants that the data were made with, from a start of 50 %."""

from collections.abc import Callable

import numpy as np
import pytest
from estimator_run import PLACES, TRUE_VELOCITY, TRUTH, new_estimator, run

from maglev.fmi.definition import read

Trial = Callable[..., dict[str, np.ndarray]]

SECONDS = {2: 40.0, 3: 20.0}


def errors(estimates: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Relative errors of the mean estimates over the last twentieth of a run."""
    found: np.ndarray = np.abs(estimates[-len(estimates) // 20:].mean(axis=0) / truth - 1.0)
    return found


@pytest.mark.thorough
@pytest.mark.parametrize("stage", [2, 3])
def test_ideal_stage(trial: Trial, stage: int) -> None:
    """Without friction and with exact encoders every constant is within half a per cent, and said to be found."""
    estimator = new_estimator(stage, 0.5 * TRUTH[stage], **TRUE_VELOCITY)
    estimates = run(stage, estimator, trial(stage, seconds=SECONDS[stage]))
    assert (errors(estimates, TRUTH[stage]) < 0.005).all()
    assert all(read(estimator, PLACES[stage][f"C{i + 1}_converged"]) for i in range(len(TRUTH[stage])))


@pytest.mark.thorough
@pytest.mark.parametrize("stage", [pytest.param(2, marks=pytest.mark.thorough), 3])
def test_encoders_and_matched_filter(trial: Trial, stage: int) -> None:
    """10 µm encoders and the observer: a bias of the thrusts, which the matched filter takes away."""
    data, thrusts = trial(stage, seconds=SECONDS[stage], resolution=10e-6), slice(0, stage - 1)
    plain, matched = (errors(run(stage, new_estimator(stage, 0.5 * TRUTH[stage], matched_filter=on), data),
                             TRUTH[stage])
                      for on in (False, True))
    assert (plain < 0.025).all()
    assert (matched < 0.005).all()
    assert (matched[thrusts] < 0.5 * plain[thrusts]).all()


@pytest.mark.thorough
@pytest.mark.parametrize(("stage", "seed", "seconds"), [(2, 1, 15.0), (3, 1, 8.0)])
def test_other_constants(trial: Trial, stage: int, seed: int, seconds: float) -> None:
    """Stages with each constant scaled by 0.8 to 1.3."""
    truth = TRUTH[stage] * np.random.default_rng(seed).uniform(0.8, 1.3, len(TRUTH[stage]))
    data = trial(stage, seconds=seconds, constants={f"C{i + 1}": float(c) for i, c in enumerate(truth)})
    estimates = run(stage, new_estimator(stage, 0.5 * TRUTH[stage], **TRUE_VELOCITY), data)
    assert (errors(estimates, truth) < [0.01] * (len(truth) - 1) + [0.03]).all()


@pytest.mark.thorough
@pytest.mark.parametrize(("index", "forgetting"), [(0, 0.0), (0, 0.2), (1, 0.2), (2, 0.2)])
def test_constant_that_jumps(trial: Trial, index: int, forgetting: float) -> None:
    """20 % at 15 s. Four seconds later an estimate that forgets is there, by (1 − γ⁻²)/ρ = 0.87 s; else it is not."""
    name = f"C{index + 1}"
    after = 1.2 * TRUTH[2][index]
    data = trial(2, seconds=20.0, change=(15.0, {name: float(after)}))
    estimates = run(2, new_estimator(2, TRUTH[2], forgetting=forgetting, **TRUE_VELOCITY), data)[:, index]
    before, late = estimates[30_000 - 1], estimates[38_000:]
    assert before == pytest.approx(TRUTH[2][index], rel=0.02)
    left = np.abs(late - after).max() / abs(after - TRUTH[2][index])
    assert left < 0.1 if forgetting else left > 0.15
