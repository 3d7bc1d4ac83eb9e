"""The study: scale the friction, fit both stages, judge all the evidence before and after, write what was found.

    python -m studies.estimation [--anew] [--fmus FOLDER]

Needs the native FMUs of this machine (`maglev build --native --target host`). Takes some ten minutes of one processor;
a stage whose fit is in `found.json` already, with the same settings, is not fitted again unless all are asked for anew.
"""

import argparse
import hashlib
import json
import math
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from maglev.arrays import Array
from pmlsm.rigs import RIGS
from studies.estimation.evidence import Judged, residual
from studies.estimation.fit import Fit, fit
from studies.estimation.flights import fly_all, judge, prepare
from studies.estimation.page import ScaleRow, best_scale, page, scale_row, write_between
from studies.estimation.settings import FILE, Defaults, Rig, Settings, read_settings, times

FOUND = Path(__file__).with_name("found.json")
DOCS = Path(__file__).parents[2] / "docs" / "estimation.md"
EFFECTS = Path(__file__).parents[2] / "scenarios" / "effects"


def fit_rig(rig: Rig, settings: Settings, fmus: Path) -> Fit:
    """Fit the parameters of one stage to the evidence that is for training."""
    experiments = prepare(rig.training, fmus)
    started, evaluations = time.monotonic(), 0

    def evidence(u: Array) -> Array:
        nonlocal evaluations
        evaluations += 1
        judged = judge(fly_all(experiments, {**settings.scale.assumed, **rig.defaults(u)},
                               {**settings.scale.follows, **rig.following(u)}), rig.training)
        row = np.array([residual(each.result, settings.largest_residual) for each in judged])
        print(f"{rig.name}: {evaluations} evaluations, {time.monotonic() - started:.0f} s, misfit "
              f"{0.5 * float(np.sum(row ** 2)):.2f}", flush=True)
        return row

    lowest = np.array([parameter.lowest for parameter in rig.parameters])
    return fit(evidence, lowest, settings.difference, settings.iterations)


def judge_all(settings: Settings, fits: dict[str, Fit], fmus: Path) -> list[Judged]:
    """Verdicts on all the evidence, at what was found of the stages that have a fit, at what is assumed of others."""
    defaults, following = {**settings.scale.assumed}, {**settings.scale.follows}
    for rig in [rig for rig in settings.rigs if rig.name in fits]:
        defaults |= rig.defaults(fits[rig.name].u)
        following |= rig.following(fits[rig.name].u)
    return judge(fly_all(prepare(None, fmus), defaults, following))


def scale_rows(settings: Settings, fmus: Path) -> list[ScaleRow]:
    """All the evidence at every scale of friction, and at the one that training chooses with slot ripple beside it."""
    experiments, scale = prepare(None, fmus), settings.scale

    def row(size: float, ripple: Defaults) -> ScaleRow:
        judged = judge(fly_all(experiments, {**times(size, scale.assumed), **ripple}, times(size, scale.follows)))
        return scale_row(settings, size, bool(ripple), judged)

    rows = [row(size, {}) for size in scale.candidates]
    return [*rows, row(best_scale(rows), scale.ripple)]


def as_data(found: Fit) -> dict[str, Any]:
    """A fit as JSON has it."""
    return {name: missing_as_none(value.tolist()) if isinstance(value, np.ndarray) else value
            for name, value in asdict(found).items()}


def missing_as_none(value: Any) -> Any:
    """Lists of numbers with None for NaN, which JSON does not have."""
    if isinstance(value, list):
        return [missing_as_none(each) for each in value]
    return None if math.isnan(value) else value


def from_data(data: dict[str, Any]) -> Fit:
    values: dict[str, Any] = {name: np.array(value, dtype=np.float64) if isinstance(value, list) else value
                              for name, value in data.items()}
    return Fit(**values)


def rounded(found: Fit) -> Fit:
    """Fit with four digits, so that what is judged is what is written."""
    def four(value: Array | float) -> Any:
        return np.vectorize(lambda each: each if math.isnan(each) else float(f"{each:.4g}"))(value)
    return Fit(four(found.u), four(found.deviations), four(found.correlations), float(four(found.cost)),
               float(four(found.cost_before)), four(found.profiles))


def effects(rig: Rig, settings: Settings, found: Fit) -> str:
    """TOML with the estimates that are the plant's, for scenarios to extend; what is not fitted is as assumed."""
    return effects_file(rig, "The effects that are fitted to part of the evidence, which the plant does not have",
                        {**settings.scale.assumed, **rig.defaults(found.u)})


def as_assumed(rig: Rig, settings: Settings) -> str:
    """TOML with what was assumed before one scale of it was estimated, for scenarios to extend."""
    return effects_file(rig, "Coulomb friction as it was assumed, before one scale of it was estimated",
                        settings.scale.assumed)


def effects_file(rig: Rig, title: str, values: Defaults) -> str:
    """TOML with start values of the plant of one stage."""
    lines = [f"# {RIGS[rig.name].title}. {title} (docs/estimation.md).",
             "# Made by `python -m studies.estimation`.", "", "[fmus.plant.start]"]
    for name, value in values.items():
        model, _, variable = name.partition(".")
        if model == f"Plant{RIGS[rig.name].suffix}":
            lines.append(f'"{variable}" = {value:.4g}')
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmus", type=Path, default=Path("fmus"), help="folder with a folder native in it")
    parser.add_argument("--anew", action="store_true", help="fit every stage, whatever was found already")
    asked = parser.parse_args()
    fmus: Path = asked.fmus
    settings, identity = read_settings(), hashlib.sha256(FILE.read_bytes()).hexdigest()
    known = json.loads(FOUND.read_text(encoding="utf-8")) if FOUND.is_file() else {}
    if asked.anew or known.get("settings") != identity:
        known = {"settings": identity, "fits": {}}
    for rig in settings.rigs:
        if rig.name not in known["fits"]:
            known["fits"][rig.name] = as_data(rounded(fit_rig(rig, settings, fmus)))
            FOUND.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    fits = {name: from_data(data) for name, data in known["fits"].items()}
    before, after = judge_all(settings, {}, fmus), judge_all(settings, fits, fmus)
    write_between(DOCS, page(settings, scale_rows(settings, fmus), fits, before, after))
    for rig in settings.rigs:
        (EFFECTS / f"{rig.name}-as-assumed.toml").write_text(as_assumed(rig, settings), encoding="utf-8")
        (EFFECTS / f"{rig.name}-estimated.toml").write_text(effects(rig, settings, fits[rig.name]), encoding="utf-8")


if __name__ == "__main__":
    main()
