"""The derivative of a block against central differences of the same block in 50 digits."""

from collections.abc import Sequence
from pathlib import Path
from random import Random
from typing import Any

import mpmath as mp
import pytest
from facts import raises
from many_digits import many_digits
from written_blocks import load_block

from maglev.analysis.realisation import numbers_of
from maglev.descriptions.registry import known_stages
from maglev.fmi.definition import FmuDefinition, read, write
from maglev.language.blocks import derivative
from maglev.language.program import FLOAT, Untranslatable
from maglev.language.statements import Program
from maglev.linear.tangent import copied

PUSH = mp.mpf("1e-18")   # along the direction: its square, and 1e-50 over it, are below 1e-31
Calls = Sequence[tuple[str, tuple[float, ...]]]

# Where there is a kink: numbers that stand for nothing else, and gains that are computed if they are left as they are.
KINKS = ("guide_seed", "kp", "ki", "kd")

# Parameters that switch on what is off, of every FMU that has them.
SWITCHED_ON = {
    "bus_voltage": 60.0, "magnet_rise": 20.0, "payload.mass": 1.0, "payload.x": 0.05, "roll.guide.stiffness": 200.0,
    "mode.frequency": 60.0, "winding.thermal_resistance": 1.0, "ripple.amplitude": 0.2, "roughness.rms": 0.2,
    "friction.variation": 0.3,    "encoder.resolution": 1.03e-5}

LOOPS = [name for name in known_stages().definitions() if name.startswith("ClosedLoop")]
PLANTS = [name for name in known_stages().definitions() if name.startswith("Plant")]
ALONE = [name for name in known_stages().definitions() if name.startswith(("Commutation", "Measurement", "Estimator"))]

LAW = """\
from math import atan, cos, exp, fabs, fmod, log, sin, sqrt, tan, tanh

from pmlsm.arctangent import arctangent, arctangent_integral
from pmlsm.exponential import exponential, exponential_minus_one
from pmlsm.logarithm import logarithm, logarithm_one_plus
from pmlsm.sine_cosine import sine_cosine, sine_of_turns
from pmlsm.whole_numbers import fraction, rounded_down


TABLE = (0.5, -2.0)
ROWS = [[1.0, 2.0], [3.0, 4.0]]


def halves(x, n):
    while n > 0:
        x = 0.5 * x
        n -= 1
    return x


def turned(x, y):
    return x - y, x + y


class Part:
    def __init__(self, x):
        self.x = x
        self.rows = [[x, 2.0], [3.0, x]]

    def moved(self, by):
        before = self.x
        self.x += by
        return before * by

    def below(self, by):
        self.x += by
        return self.x < 2.0


class Law:
    def __init__(self):
        self.a, self.b, self.on, self.count = 0.3, -1.7, True, 3
        self.parts = [Part(0.4), Part(-0.8)]
        self.found = [0.0] * 41

    def step(self, t):
        a, b, found = self.a, self.b, self.found
        found[0], found[1] = sqrt(a), fabs(b)
        found[2], found[3] = sin(a), cos(a)
        found[4], found[5] = tan(b), exp(b)
        found[6], found[7] = log(a), atan(b)
        found[8], found[9] = tanh(a), exponential(a)
        found[10], found[11] = exponential_minus_one(b), logarithm(a)
        found[12], found[13] = logarithm_one_plus(a), arctangent(b)
        found[14], found[15] = arctangent_integral(a), fraction(b)
        found[16], found[17] = sine_cosine(a * b)
        found[18], found[19] = sine_of_turns(b), rounded_down(b)
        found[20], found[21] = min(a, b), max(a, b, a * b)
        found[22], found[23] = a / b, -(b / 2.0) - 1.0 / a
        found[24] = a * b * b if self.on else a
        found[25] = self.parts[0].moved(a) if self.on and self.parts[1].moved(b) < 9.0 else 1.0
        found[26], found[27] = turned(a * a, b)
        found[28] = halves(b, self.count)
        for k, part in enumerate(self.parts):
            for row in part.rows:
                for number in row:
                    found[29 + k] += number * a
            part.rows[k][0] *= b
        found[31] = float(int(b)) * a
        if 0.0 < a < 1.0 and not self.on:
            found[32] = b
        elif a > b:
            found[32] = fabs(a) * abs(b)
        for k in range(self.count, 0, -1):
            if k == 2:
                continue
            found[33] = found[33] * a + float(k)
        a, b = b, a
        found[34] = a - 2.0 * b
        found[35] = fraction(-a) * fabs(-b)
        nearest = self.parts[0] if a > b else self.parts[1]
        found[36] = nearest.x * (self.parts[1] if self.on else self.parts[0]).x
        while self.parts[0].below(0.17):
            found[37] += a
        if (a < 0.0) & self.on | (b < 0.0):
            found[38] = a * b
        for factor, row in zip(TABLE, ROWS):
            found[40] += factor * a * row[1]
        found[39] = a * sin(0.5) * sine_of_turns(0.1) * fmod(5.0, 2.0)
"""


def directed(definition: FmuDefinition, block: Any, random: Random) -> dict[str, float]:
    """Switch on what is off, move inputs and states, and return a direction: by its path, how fast a number changes."""
    direction = {}
    states = definition.continuous.states if definition.continuous else ()
    for each in definition.variables:
        value = each.read(block)
        if each.causality not in ("input", "parameter") or not isinstance(value, float):
            continue
        for name, on in SWITCHED_ON.items():
            if each.name == name or each.name.endswith("." + name):
                each.write(block, on)
        if each.causality == "input":
            each.write(block, value + random.gauss(0.0, 1e-4 if value else 0.3))
        if (value := each.read(block)) and not each.name.endswith(KINKS):   # what is off stays off
            direction[each.place] = value * random.gauss(0.0, 1.0)
    places = {variable.name: variable.place for variable in definition.native_variables}
    return direction | {places[state.variable]: random.gauss(0.0, 1e-3) for state in states}


def check(block: Any, direction: dict[str, float], calls: Calls) -> set[str]:
    """Compare what calls in turn leave in all numbers of a block; return the paths of those that change."""
    places = numbers_of(block)
    program, found, along = Program(block), copied(block), copied(block)
    for place in places:
        write(along, place, direction.get(place, 0.0))
    for method, arguments in calls:
        program.method(method, [FLOAT] * len(arguments))
        derivative(block, method, [FLOAT] * len(arguments))(found, along, *(
            part for value in arguments for part in (value, 0.0)))
    ends = []
    with many_digits(each.source for each in program.functions.values()):
        for push in (PUSH, -PUSH):
            moved = copied(block)
            for place in places:
                write(moved, place, mp.mpf(read(block, place)) + push * direction.get(place, 0.0))
            for method, arguments in calls:
                assert not getattr(moved, method)(*map(mp.mpf, arguments))
            ends.append([mp.mpf(read(moved, place)) for place in places])
        values = {place: (float((a + b) / 2), float((a - b) / (2 * PUSH)))
                  for place, a, b in zip(places, *ends, strict=True)}
    for place, (value, slope) in values.items():
        assert read(found, place) == pytest.approx(value, rel=1e-10, abs=1e-12, nan_ok=True), place
        assert mp.isnan(slope) or read(along, place) == pytest.approx(slope, rel=1e-10, abs=1e-12), place
    return {place for place, (_, slope) in values.items() if slope != 0.0}


def sample_time(block: Any) -> float:
    for part in ("controller", "regulator"):
        block = getattr(block, part, block)
    return float(getattr(block, "sample_time", 2e-4))


@pytest.mark.few(4)
@pytest.mark.parametrize("name", [*LOOPS, *ALONE])
def test_two_steps_from_the_start(name: str) -> None:
    definition = known_stages().definition(name)
    block = definition.new_block()
    direction = directed(definition, block, Random(name))
    dt = sample_time(block)
    assert len(check(block, direction, [("start", ()), ("step", (0.0, dt)), ("step", (dt, dt))])) > len(direction)


@pytest.mark.parametrize("name", PLANTS)
def test_rates_of_a_continuous_model(name: str) -> None:
    definition = known_stages().definition(name)
    block = definition.new_block()
    direction = directed(definition, block, Random(name))
    assert len(check(block, direction, [("start", ()), ("derive", ())])) > len(direction)


def test_every_function_and_statement(tmp_path: Path) -> None:
    block = load_block(tmp_path, LAW, "Law")
    direction = {"a": 0.7, "b": -0.4, "parts[0].x": 1.3, "parts[1].rows[0][1]": 0.2}
    changing = check(block, direction, [("step", (0.5,)), ("step", (0.75,))])
    assert {f"found[{k}]" for k in range(41)} - changing == {"found[19]"}   # rounded_down


@pytest.mark.parametrize("function", ["fmod", "atan2", "erf"])
def test_refuses_a_function_without_a_rule(function: str, tmp_path: Path) -> None:
    values = "self.a" if function == "erf" else "self.a, 2.0"
    block = load_block(tmp_path, f"from math import {function}\n\n\nclass Law:\n    def __init__(self):\n"
                       f"        self.a = 1.0\n\n    def step(self):\n        self.a = {function}({values})\n", "Law")
    with raises(Untranslatable, "tank.py", "line 8", f"{function}()", "step"):
        derivative(block, "step")
