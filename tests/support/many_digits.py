"""Blocks in numbers of 50 digits: their own Python, with functions of `math` and elementary ones as mpmath has them."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import mpmath as mp

DIGITS = 50
NAMED: dict[str, Callable[..., Any]] = {name: getattr(mp, name) for name in (
    "sqrt", "fabs", "sin", "cos", "tan", "exp", "log", "atan", "tanh")} | {
    "exponential": mp.exp, "exponential_minus_one": mp.expm1, "logarithm": mp.log, "logarithm_one_plus": mp.log1p,
    "arctangent": mp.atan, "arctangent_integral": lambda x: x * mp.atan(x) - mp.log1p(x * x) / 2,
    "sine_cosine": lambda x: (mp.sin(x), mp.cos(x)), "sine_of_turns": lambda x: mp.sin(2 * mp.pi * x),
    "fraction": lambda x: x - mp.nint(x), "rounded_down": mp.floor}

ELEMENTARY = {f"pmlsm.{name}" for name in ("arctangent", "exponential", "logarithm", "sine_cosine", "whole_numbers")}


@contextmanager
def many_digits(functions: Iterable[Callable[..., Any]]) -> Iterator[None]:
    """Let functions call mpmath's functions instead of those of `math` and of `pmlsm`."""
    modules = {id(function.__globals__): function.__globals__ for function in functions}
    before = [(names, name, value) for names in modules.values() for name, value in names.items()
              if name in NAMED and callable(value) and names["__name__"] not in ELEMENTARY]
    try:
        for names, name, _ in before:
            names[name] = NAMED[name]
        with mp.workdps(DIGITS):
            yield
    finally:
        for names, name, value in before:
            names[name] = value
