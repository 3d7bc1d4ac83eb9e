"""The study: scale the friction, try roughness beside it, judge all the evidence, write what was found.

    python -m studies.estimation [--anew]

Takes half an hour of one processor; an estimate that is in `found.json` already, with the same settings, is not made
again unless all are asked for anew.
"""

import argparse
import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pmlsm.rigs import RIGS
from studies.estimation.causes import causes
from studies.estimation.evidence import Judged
from studies.estimation.flights import fly_all, judge, prepare
from studies.estimation.page import RoughRow, ScaleRow, best_scale, page, scale_row, write_between
from studies.estimation.roughness import Estimate, Flight, estimate, sums
from studies.estimation.settings import FILE, Defaults, Settings, read_settings, times

FOUND = Path(__file__).with_name("found.json")
DOCS = Path(__file__).parents[2] / "docs" / "estimation.md"
EFFECTS = Path(__file__).parents[2] / "scenarios" / "effects"
STAGES = ("2dof", "3dof")   # that the thesis has


def judge_all(settings: Settings, scale: float, defaults: Defaults) -> list[Judged]:
    """Verdicts on all the evidence at a scale of friction."""
    return judge(fly_all(prepare(None), {**times(scale, settings.scale.assumed), **defaults},
                         times(scale, settings.scale.follows)))


def scale_rows(settings: Settings) -> list[ScaleRow]:
    """All the evidence at every scale of friction, and at the one that training chooses with slot ripple beside it."""
    rows = [scale_row(settings, size, False, judge_all(settings, size, {}))
            for size in settings.scale.candidates]
    best = best_scale(rows)
    return [*rows, scale_row(settings, best, True, judge_all(settings, best, settings.scale.ripple))]


def flight(settings: Settings, names: Sequence[str] | None) -> Flight:
    """A function that flies runs by name, or all, with roughness, and judges them."""
    experiments = prepare(names)

    def fly(scale: float, rms: Defaults, seed: int) -> list[Judged]:
        tracks = {f"Plant{RIGS[rig].suffix}.roughness_seed": float(seed) for rig in STAGES}
        return judge(fly_all(experiments, {**times(scale, settings.scale.assumed), **rms, **tracks},
                             times(scale, settings.scale.follows)), names)
    return fly


def rough_rows(settings: Settings, scale: float, best: Estimate) -> list[RoughRow]:
    """All the evidence without roughness at the scale that is chosen alone, then with it on the tracks for judging."""
    without, rough, fly = judge_all(settings, scale, {}), settings.roughness, flight(settings, None)
    rows = [RoughRow(f"× {scale:g}, no roughness", sums(rough, settings.training, [without] * len(rough.judging)),
                     [without])]
    for share in (1.0, *rough.lesser):
        flown = [fly(best.scale, times(share, best.rms), seed) for seed in rough.judging]
        label = "with roughness" if share == 1.0 else f"{share:g} of that roughness"
        rows.append(RoughRow(f"× {best.scale:g}, {label}", sums(rough, settings.training, flown), flown))
        print(rows[-1].label, rows[-1].sums, flush=True)
    return rows


def estimates(settings: Settings, known: dict[str, Any]) -> list[Estimate]:
    """Roughness at every scale of friction; what is known already is not estimated again."""
    fly = flight(settings, sorted(settings.training))
    for scale in settings.roughness.scales:
        if f"{scale:g}" not in known["estimates"]:
            found = estimate(settings.roughness, scale, fly)
            known["estimates"][f"{scale:g}"] = asdict(found)
            print(found, flush=True)
            FOUND.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    return [Estimate(**each) for each in known["estimates"].values()]


def as_assumed(name: str, settings: Settings) -> str:
    """TOML with what was assumed before one scale of it was estimated, for scenarios to extend."""
    rig = RIGS[name]
    lines = [f"# {rig.title}. Coulomb friction as it was assumed, before one scale of it was estimated "
             "(docs/estimation.md).", "# Made by `python -m studies.estimation`.", "", "[fmus.plant.start]"]
    lines += [f'"{variable}" = {value:.4g}' for model, _, variable, value in (
        (*variable.partition("."), value) for variable, value in settings.scale.assumed.items())
        if model == f"Plant{rig.suffix}"]
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--anew", action="store_true", help="estimate all, whatever was found already")
    asked = parser.parse_args()
    settings, identity = read_settings(), hashlib.sha256(FILE.read_bytes()).hexdigest()
    known = json.loads(FOUND.read_text(encoding="utf-8")) if FOUND.is_file() else {}
    if asked.anew or known.get("settings") != identity:
        known = {"settings": identity, "estimates": {}}
    found = estimates(settings, known)
    scales = scale_rows(settings)
    best = best_scale(scales[:-1])
    rows = rough_rows(settings, best, max(found, key=lambda each: each.log_likelihood))
    scaled: dict[str, Sequence[Judged]] = {
        f"Coulomb friction × {row.scale:g}" + (", slot ripple" if row.ripple else ""): [*row.training, *row.held_out]
        for row in scales if row.scale != best or row.ripple}
    others: dict[str, Sequence[Judged]] = {words: judge_all(settings, best, defaults)
                                           for words, defaults in settings.causes.items()}
    write_between(DOCS, page(settings, scales, found, rows, scaled, {**others, **dict(causes())}))
    for name in STAGES:
        (EFFECTS / f"{name}-as-assumed.toml").write_text(as_assumed(name, settings), encoding="utf-8")


if __name__ == "__main__":
    main()
