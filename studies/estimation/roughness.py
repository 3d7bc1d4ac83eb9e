"""Rail roughness and one scale of friction, estimated together from the sentences for training, over many tracks."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from maglev.judging.verdicts import ClaimResult
from maglev.schema.judged.claims import RunClaim
from studies.estimation.evidence import Judged, log_likelihood
from studies.estimation.settings import Defaults, RoughnessSettings, times

PARABOLAS = "procedure-1"   # how the names of Procedure 1 end

# Results of each sentence on every track, by its key.
Tracks = Mapping[str, Sequence[ClaimResult]]
# Judged evidence at a scale of friction, with the rms of each axis, on the track of a seed.
Flight = Callable[[float, Defaults, int], Sequence[Judged]]


@dataclass(frozen=True)
class Estimate:
    """What the sentences for training say at one scale of friction."""

    scale: float
    rms: Defaults           # of each axis, m/s²
    log_likelihood: float   # of all sentences for training


class Sums(NamedTuple):
    """Log-likelihoods of sentences."""

    training: float
    held_out: float
    parabolas: float   # of those held out that are about Procedure 1


class Spread(NamedTuple):
    """What is measured over tracks; infinite where a run did not complete, or it never happened."""

    low: float      # of which a tenth of the tracks has less
    median: float
    high: float     # of which a tenth has more


def over_tracks(flown: Iterable[Sequence[Judged]]) -> dict[str, list[ClaimResult]]:
    """Results of every sentence that can be tested, by its key, over tracks."""
    found: dict[str, list[ClaimResult]] = {}
    for judged in flown:
        for each in judged:
            if each.result.claim.figure is None and each.result.claim.quantity is not None:
                found.setdefault(each.key, []).append(each.result)
    return found


def estimate(settings: RoughnessSettings, scale: float, fly: Flight) -> Estimate:
    """Find the rms of each axis at a scale of friction.

    All axes are tried together at each multiple of what the file begins with; that of an axis is chosen by the
    sentences that are about this axis alone, for what one axis does hardly depends on the tracks of the others.
    """
    by_axis: dict[str, list[float]] = {name: [] for name in settings.rms}
    for multiple in settings.multiples:
        tracks = over_tracks(fly(scale, times(multiple, settings.rms), seed) for seed in settings.tracks)
        for name, found in by_axis.items():
            found.append(math.fsum(log_likelihood(results, settings.outliers) for results in tracks.values()
                                   if about(name, results[0])))
    rms = {name: settings.rms[name] * settings.multiples[int(np.argmax(found))] for name, found in by_axis.items()}
    tracks = over_tracks(fly(scale, rms, seed) for seed in settings.tracks)
    return Estimate(scale, rms, total(tracks.values(), settings.outliers))


def about(name: str, result: ClaimResult) -> bool:
    """Whether a sentence is about the axis of a variable such as "Plant3DOF.x.roughness.rms", and about no other."""
    claim = result.claim
    return isinstance(claim, RunClaim) and claim.axes == [name.split(".")[1]] and claim.than_axis is None


def total(results: Iterable[Sequence[ClaimResult]], outliers: float) -> float:
    """Log-likelihood of sentences."""
    return math.fsum(log_likelihood(each, outliers) for each in results)


def sums(settings: RoughnessSettings, training: frozenset[str], flown: Sequence[Sequence[Judged]]) -> Sums:
    """Log-likelihoods of the parts of the evidence; without roughness all tracks are one."""
    parts = (lambda owner: owner in training, lambda owner: owner not in training,
             lambda owner: owner.endswith(PARABOLAS))
    return Sums(*(total(over_tracks([each for each in judged if part(each.owner)] for judged in flown).values(),
                        settings.outliers) for part in parts))


def adopted(without: Sums, rough: Sums) -> bool:
    """Whether roughness is taken over: what is held out is more likely with it, and the parabolas alone are."""
    return rough.held_out > without.held_out and rough.parabolas > without.parabolas


def spread(results: Sequence[ClaimResult]) -> Spread:
    """Spread of what was measured over tracks."""
    found = [math.nan if each.measured is None else float(each.measured) for each in results]
    values = [math.inf if math.isnan(value) else value for value in found]   # an equilibrium that is not there is NaN
    return Spread(*(float(each) for each in np.percentile(values, [10.0, 50.0, 90.0], method="nearest")))
