"""What the gated benchmarks share: their options, and rounds in which all ways are measured."""

import argparse
from collections.abc import Callable, Mapping
from pathlib import Path

ROUNDS = 7   # the fastest counts, which is the least disturbed
ENOUGH = 3   # for the gate, if none of them has a ratio that is too large: then the fastest have none

TooLarge = Callable[[Mapping[str, float]], dict[str, float]]   # by way, ratios above their limits


def options(about: str | None, gates: Mapping[str, float]) -> argparse.Namespace:
    """Options of a benchmark: gate, record, fmus."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--gate", action="store_true", help=f"only what is gated; fail if a ratio exceeds {gates}")
    parser.add_argument("--record", action="store_true", help="add the ratios to the history of this commit")
    parser.add_argument("--fmus", type=Path, help="folder of FMUs that are built, in its folders python and native")
    return parser.parse_args()


def fastest(ways: Mapping[str, Callable[[], float]], too_large: TooLarge, gate: bool,
            repeats: Mapping[str, int] | None = None) -> dict[str, float]:
    """Shortest time (s) of each way, measured in turn, so that a disturbance meets all of them.

    Some are measured several times in a round. For the gate a few rounds do, if each holds the limits.
    """
    times: dict[str, list[float]] = {name: [] for name in ways}
    held = 0
    for done in range(1, ROUNDS + 1):
        of_round = {name: min(way() for _ in range((repeats or {}).get(name, 1))) for name, way in ways.items()}
        for name, time in of_round.items():
            times[name].append(time)
        held += not too_large(of_round)
        if gate and held == done == ENOUGH:
            break
    return {name: min(taken) for name, taken in times.items()}
