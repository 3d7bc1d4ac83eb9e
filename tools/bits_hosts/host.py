"""Run a plan in JSON on any Python from 3.11 on, with only its standard library and the blocks.

    python host.py FOLDER < plan.json

FOLDER has the packages of the blocks. Writes the digest, as host.c does.
"""

import json
import struct
import sys
from importlib import import_module
from typing import Any

EMPTY_DIGEST = 14695981039346656037
PRIME = 1099511628211


def digest(run: dict[str, Any]) -> int:
    """Return FNV-1a, 64 bits, of the numbers of a run; 0 if a block refused a step."""
    sine_of_turns = import_module("pmlsm.sine_cosine").sine_of_turns
    of_blocks = import_module("maglev.fmi.definition")
    names: dict[str, Any] = {}
    exec(run["definition"], names)
    loop = names["DEFINITION"].new_block()
    for place, value in run["start"].items():
        of_blocks.write(loop, place, value)
    if loop.start():
        return 0
    waves = [(*of_blocks.slot(loop, place), *wave) for place, wave in run["waves"].items()]
    numbers, packed = of_blocks.reader(run["numbers"]), struct.Struct(f"<{len(run['numbers'])}d")
    step, result = run["step"], EMPTY_DIGEST
    for k in range(run["steps"]):
        t = k * step
        for part, name, middle, amplitude, frequency, phase in waves:
            of_blocks.put(part, name, middle + amplitude * sine_of_turns(frequency * t + phase))
        if loop.step(t, step):
            return 0
        for byte in packed.pack(*numbers(loop)):
            result = (result ^ byte) * PRIME & 0xFFFFFFFFFFFFFFFF
    return result


if __name__ == "__main__":
    sys.path.insert(0, sys.argv[1])
    print(f"{digest(json.load(sys.stdin)):016x}")
