"""Kinds of FMUs of this project, whose results have the same bits."""

import warnings
from collections.abc import Callable
from functools import wraps
from typing import Literal, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

KindName = Literal["python", "native"]
"""The FMUs that this project builds."""


def reads_native(function: Callable[P, T]) -> Callable[P, T]:
    """Let a function read native=True, as it was called before, as kind="native"; for one version."""
    @wraps(function)
    def called(*arguments: P.args, **options: P.kwargs) -> T:
        if "native" in options:
            warnings.warn("native=True is kind='native' now, and runs need neither", stacklevel=2)
            if options.pop("native"):
                options["kind"] = "native"
        return function(*arguments, **options)
    return called
