"""The run of a plan in JSON, on any Python from 3.11 on, with nothing but its standard library and the blocks.

    python host.py FOLDER < plan.json

FOLDER has the packages of the blocks. Writes the digest, as host.c does.
"""

import json
import struct
import sys
from functools import reduce
from importlib import import_module
from operator import attrgetter
from typing import Any

EMPTY_DIGEST = 14695981039346656037
PRIME = 1099511628211


def digest(run: dict[str, Any]) -> int:
    """FNV-1a, 64 bits, of the numbers of a run; 0 if it was refused."""
    sine_of_turns = import_module("pmlsm.elementary.sine_cosine").sine_of_turns
    loop = getattr(import_module(run["module"]), run["block"])(*run["arguments"])
    for place, value in run["start"].items():
        setattr(*owner(loop, place), value)
    if loop.start():
        return 0
    waves = [(*owner(loop, place), *wave) for place, wave in run["waves"].items()]
    numbers, packed = attrgetter(*run["numbers"]), struct.Struct(f"<{len(run['numbers'])}d")
    step, result = run["step"], EMPTY_DIGEST
    for k in range(run["steps"]):
        t = k * step
        for part, name, middle, amplitude, frequency, phase in waves:
            setattr(part, name, middle + amplitude * sine_of_turns(frequency * t + phase))
        if loop.step(t, step):
            return 0
        for byte in packed.pack(*numbers(loop)):
            result = (result ^ byte) * PRIME & 0xFFFFFFFFFFFFFFFF
    return result


def owner(loop: Any, place: str) -> tuple[Any, str]:
    """Part of a block that has an attribute, and the attribute's name, by its path."""
    *parts, name = place.split(".")
    return reduce(getattr, parts, loop), name


if __name__ == "__main__":
    sys.path.insert(0, sys.argv[1])
    print(f"{digest(json.load(sys.stdin)):016x}")
