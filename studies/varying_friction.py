"""Coulomb friction whose level varies along the guide, judged by the rule of docs/estimation.md.

    python -m studies.varying_friction --rows FILE

Training chooses the level, its variation and its correlation length. The held-out evidence judges the result next to
today's plants, all of the friction first assumed, and rough guides. It writes the tables of docs/estimation.md and
docs/claims.md, and takes half an hour of processor time. Every row of evidence goes to FILE and is not computed again.
"""

import argparse
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from maglev.api.comparing import run_compared
from maglev.api.options import experiments_of
from maglev.files.marked import markdown_table, write_part
from maglev.files.side_by_side import unwatched
from maglev.runs.chain import compared_with, needed, select
from maglev.runs.preparation import Experiment
from maglev.scenario.claims import Claim
from studies.estimation import DOCS, Defaults, Settings, judge_claims, read_settings, residual, times, with_defaults

SCALES = (0.5, 0.75, 1.0, 1.25)        # L
VARIATIONS = (0.2, 0.4)                # s
LENGTHS = (4e-3, 8e-3, 16e-3)          # ℓ, m
TRAINING_TRACKS = range(1, 13)
HELD_OUT_TRACKS = range(13, 33)
PARABOLAS = ("2dof-procedure-1", "3dof-procedure-1")
CONTRADICTORY = ("2dof-setpoints", "overshoot is quite large")   # the overshoot of "100 %"
CLOSE = 0.1   # share of a printed number within which the median of the tracks reproduces it

CLAIMS = DOCS.with_name("claims.md")

ROUGHNESS = {   # rms of the earlier study, m/s²
    "Plant2DOF.v.roughness.rms": 1.2, "Plant2DOF.h.roughness.rms": 0.18,
    "Plant3DOF.y.roughness.rms": 0.09, "Plant3DOF.x.roughness.rms": 0.0975, "Plant3DOF.z.roughness.rms": 0.15}
TODAY = "× 0.5"


@dataclass(frozen=True)
class Candidate:
    """Friction and guides of both stages; without tracks there is one run."""

    name: str
    scale: float
    effects: Defaults
    random: bool

    def tracks(self, of: range) -> list[int]:
        return [*of] if self.random else [0]


@dataclass(frozen=True)
class JudgedClaim:
    """A claim of a run or a procedure, as a row has it."""

    experiment: str
    text: str
    target: float | None   # of a printed number
    measured: float | None
    residual: float


Row = list[JudgedClaim]
Counted = Callable[[JudgedClaim], bool]
Training = dict[tuple[float, float, float], float]   # log-likelihood by L, s and ℓ (m)
Misfits = dict[str, NDArray[np.float64]]   # by experiment, one a track


def varying(settings: Settings, scale: float, variation: float, length: float) -> Candidate:
    """Friction of a level that varies along the guides of all axes."""
    parts = [name.removesuffix("coulomb") for name in settings.assumed]
    effects = {f"{part}variation": variation for part in parts} | {f"{part}correlation": length for part in parts}
    return Candidate(f"× {scale:g} ± {100 * variation:g} % along {1e3 * length:g} mm", scale, effects, random=True)


class Rows:
    """Judged evidence of candidates on tracks, kept in a file."""

    def __init__(self, file: Path, settings: Settings):
        self.file = file
        self.settings = settings
        lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
        self.known: dict[str, Row] = {}
        for line in lines:
            row = json.loads(line)
            self.known[row["key"]] = [JudgedClaim(*claim) for claim in row["claims"]]
        self.experiments: dict[bool, list[Experiment]] = {}

    def row(self, candidate: Candidate, track: int, training: bool) -> Row:
        """Claims on a track: those that train, or those that are held out."""
        key = f"{'training' if training else 'all'}, {candidate.name}, track {track}"
        if key not in self.known:
            self.known[key] = self.computed(candidate, track, training)
            with self.file.open("a", encoding="utf-8") as out:
                claims = [[claim.experiment, claim.text, claim.target, claim.measured, claim.residual]
                          for claim in self.known[key]]
                out.write(json.dumps({"key": key, "claims": claims}) + "\n")
        return self.known[key]

    def prepared(self, training: bool) -> list[Experiment]:
        if training not in self.experiments:
            plans = [plan for plan in select(None) if not plan.another_reading and (
                plan.claims or (plan.procedure is not None and plan.procedure.claims))]
            plans = [plan for plan in plans if plan.name in self.settings.training or not training]
            plans = [*plans, *compared_with(plans)]
            self.experiments[training] = experiments_of([*plans, *needed(plans)], {})
        return self.experiments[training]

    def computed(self, candidate: Candidate, track: int, training: bool) -> Row:
        settings = self.settings
        defaults = {**times(candidate.scale, settings.assumed), **candidate.effects,
                    **{f"Plant{stage}DOF.guide_seed": float(track) for stage in (2, 3)}}
        follows = times(candidate.scale, settings.follows)
        experiments = [replace(each, plan=with_defaults(each.plan, defaults, follows))
                       for each in self.prepared(training)]
        row = []
        for owner, result in judge_claims(list(run_compared(experiments, unwatched).values())):
            claim = result.claim
            if training and owner not in settings.training:
                continue
            target = claim.target if claim.relation == "about" and isinstance(claim.target, float) else None
            measured = None if result.measured is None else float(result.measured)
            row.append(JudgedClaim(owner, claim.text, target, measured, residual(result, settings.largest_residual)))
        return row


def misfits_of(rows: Sequence[Row], counted: Counted) -> Misfits:
    """Half the sum of squared residuals of each experiment on each track."""
    experiments = dict.fromkeys(claim.experiment for claim in rows[0] if counted(claim))
    return {name: np.array([0.5 * sum(claim.residual**2 for claim in row if claim.experiment == name and counted(claim))
                            for row in rows]) for name in experiments}


def log_likelihoods(misfits: Misfits) -> NDArray[np.float64]:
    """Logarithm of the mean of exp(−misfit) over the tracks, by experiment."""
    return np.array([math.log(np.mean(np.exp(least - each))) - least
                     for each in misfits.values() for least in [each.min()]])


def jackknife_variance(left_out: Sequence[float]) -> float:
    """Variance of a value from its values without each one of its parts."""
    count = len(left_out)
    return float((count - 1) * np.var(left_out))


def difference(candidate: Misfits, today: Misfits) -> tuple[float, float]:
    """Log-likelihood less that of today's plants, and its standard error.

    The error adds the jackknife variances over experiments and over tracks. A sum without one of n experiments counts
    n/(n − 1) times, since a sum grows with their number.
    """
    each = log_likelihoods(candidate) - log_likelihoods(today)
    whole, count = float(each.sum()), len(each)
    variance = jackknife_variance([(whole - one) * count / (count - 1) for one in each])
    tracks = len(next(iter(candidate.values())))
    if tracks > 1:
        variance += jackknife_variance([
            float(log_likelihoods({name: np.delete(one, track) for name, one in candidate.items()}).sum())
            for track in range(tracks)])
    return whole, math.sqrt(variance)


def decision(held_out: tuple[float, float], parabolas: tuple[float, float]) -> str:
    """Verdict of the rule on D and P, each with its standard error."""
    if held_out[0] < -2.0 * held_out[1] or parabolas[0] < -2.0 * parabolas[1]:
        return "rejected"
    return "replaces roughness" if held_out[0] > 2.0 * held_out[1] else "undecided"


def train(rows: Rows, counted: Counted) -> Training:
    """Log-likelihood of the training evidence of every combination."""
    found = {}
    for scale, variation, length in product(SCALES, VARIATIONS, LENGTHS):
        candidate = varying(rows.settings, scale, variation, length)
        judged = [rows.row(candidate, track, training=True) for track in TRAINING_TRACKS]
        found[scale, variation, length] = float(log_likelihoods(misfits_of(judged, counted)).sum())
    return found


def best_of(training: Training) -> tuple[float, float, float]:
    return max(training, key=lambda each: training[each])


def judge(rows: Rows, candidate: Candidate) -> list[Row]:
    """All evidence of a candidate on the tracks that judge it."""
    return [rows.row(candidate, track, training=False) for track in candidate.tracks(HELD_OUT_TRACKS)]


def training_table(training: Training) -> str:
    """Log-likelihood by level down, variation and length along; the best is bold."""
    best = best_of(training)
    columns = [*product(VARIATIONS, LENGTHS)]
    bold = {best: "**"}
    return markdown_table(["L", *(f"s {s:g}, ℓ {1e3 * length:g} mm" for s, length in columns)], (
        [f"{scale:g}", *(f"{mark}{training[scale, *column]:.1f}{mark}" for column in columns
                         for mark in [bold.get((scale, *column), "")])] for scale in SCALES))


def judged_table(differences: Sequence[tuple[str, tuple[float, float], tuple[float, float]]]) -> str:
    """D and P of each candidate with their standard errors."""
    return markdown_table(("candidate", "D", "P"), (
        (name, f"{d[0]:.1f} ± {d[1]:.1f}", f"{p[0]:.1f} ± {p[1]:.1f}") for name, d, p in differences))


def printed_claims() -> dict[tuple[str, str], Claim]:
    """Claims that print a number, by experiment and sentence."""
    found: dict[tuple[str, str], Claim] = {}
    for plan in select(None):
        of_procedure = plan.procedure.claims if plan.procedure else []
        found |= {(plan.name, claim.text): claim for claim in plan.claims if claim.relation == "about"}
        found |= {(plan.procedure.name, claim.text): claim for claim in of_procedure
                  if plan.procedure and claim.relation == "about"}
    return found


def printed_table(today: Row, tracks: Sequence[Row], name: str) -> str:
    """Printed numbers of the thesis, as today's plants have them and as varying friction has them over tracks."""
    claims = printed_claims()
    rows = []
    reproduced, within = 0, 0
    for number, claim in enumerate(today):
        if claim.target is None:
            continue
        values = np.array([row[number].measured for row in tracks], dtype=np.float64)
        low, median, high = np.quantile(values, [0.1, 0.5, 0.9], method="nearest")
        of = claims[claim.experiment, claim.text]
        inside = bool(low <= claim.target <= high)
        met = inside and abs(median - claim.target) <= CLOSE * abs(claim.target)
        reproduced, within = reproduced + met, within + inside
        numbers = [of.printed(value) for value in (claim.target, claim.measured, float(median))]
        band = f"{of.printed(float(low))} … {of.printed(float(high))}"
        rows.append([f"`{claim.experiment}`", claim.text, *numbers, band,
                     "yes" if met else "inside" if inside else "no"])
    heads = ("run", "claim", "printed", TODAY, f"{name}, median", "first to last tenth", "reproduced")
    return (f"{markdown_table(heads, rows)}\n{within} of {len(rows)} numbers lie between the first and the last tenth "
            f"of the tracks; {reproduced} of these have a median within 10 %, too.")


def main() -> None:
    """Train, judge the held-out evidence, and write what was found."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rows", type=Path, required=True, help="file of the rows that were computed")
    settings = read_settings()
    rows = Rows(parser.parse_args().rows, settings)

    def held_out(claim: JudgedClaim) -> bool:
        return claim.experiment not in settings.training

    def parabola(claim: JudgedClaim) -> bool:
        return claim.experiment in PARABOLAS

    training = train(rows, lambda claim: True)
    best = varying(settings, *best_of(training))
    without = varying(settings, *best_of(train(rows, lambda claim: (
        claim.experiment != CONTRADICTORY[0] or CONTRADICTORY[1] not in claim.text))))
    candidates = [Candidate(TODAY, 0.5, {}, random=False), best, Candidate("× 1", 1.0, {}, random=False),
                  Candidate("× 0.75, rough guides", 0.75, ROUGHNESS, random=True)]
    candidates += [without] if without != best else []
    judged = {each.name: judge(rows, each) for each in candidates}
    today = judged.pop(TODAY)
    differences = [(name, difference(misfits_of(found, held_out), misfits_of(today, held_out)),
                    difference(misfits_of(found, parabola), misfits_of(today, parabola)))
                   for name, found in judged.items()]
    decided = decision(*differences[0][1:])
    chosen = "the same, so that D does not change" if without == best else without.name
    text = (f"{training_table(training)}\n{judged_table(differences)}\nThe decision is **{decided}**. Without the "
            f"overshoot of \"100 %\" training chooses {chosen}.")
    write_part(DOCS, "varying friction", text)
    write_part(CLAIMS, "varying friction", printed_table(today[0], judged[best.name], best.name))


if __name__ == "__main__":
    main()
