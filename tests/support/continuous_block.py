"""A plant's block as Model Exchange has it: states, rates, events, and derivatives along a direction."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from maglev.descriptions.own_fmus import definition
from maglev.fmi.definition import ContinuousModel, put, read, write
from maglev.language.blocks import derivative
from maglev.linear.tangent import numbers_of


def zeros(block: Any) -> Any:
    """A block of zeros, such as a direction."""
    for owner, key, value in numbers_of(block):
        if isinstance(value, float):
            put(owner, key, 0.0)
    return block


class ContinuousBlock:
    """A block of an FMU with values of parameters and inputs, started, with its first event taken in."""

    def __init__(self, name: str, values: Mapping[str, float | bool]):
        self.definition = definition(name)
        model = self.definition.continuous
        assert model is not None
        self.model: ContinuousModel = model
        self.places = {v.name: v.place for v in self.definition.native_variables}
        self.states = [state.variable for state in model.states]
        self.rates = [state.derivative for state in model.states]
        self.inputs = [v.name for v in self.definition.variables if v.causality == "input"]
        self.block = self.definition.new_block()
        # The function that a native FMU has as C: derivatives of what `derive` computes, along a direction.
        self.differentiate = derivative(self.definition.new_block(), "derive")
        for key, value in values.items():
            self.set(key, value)
        assert self.block.start() == 0
        self.block.settle()

    def set(self, name: str, value: float | bool, block: Any = None) -> None:
        write(self.block if block is None else block, self.places[name], value)

    def get(self, names: Sequence[str], block: Any = None) -> np.ndarray:
        return np.array([read(self.block if block is None else block, self.places[name]) for name in names])

    def at(self, names: Sequence[str], values: Sequence[float] | np.ndarray, wanted: Sequence[str]) -> np.ndarray:
        """Values of variables at a point."""
        for name, value in zip(names, values, strict=True):
            self.set(name, float(value))
        self.block.derive()
        return self.get(wanted)

    def jacobian(self, unknowns: Sequence[str], knowns: Sequence[str]) -> np.ndarray:
        """Derivatives at the present point, a column for each known."""
        columns = []
        for known in knowns:
            direction = zeros(self.definition.new_block())
            self.set(known, 1.0, direction)
            self.differentiate(self.block, direction)
            columns.append(self.get(unknowns, direction))
        return np.array(columns).T

    def solve(self, stop_time: float) -> np.ndarray:
        """States at the stop time (s) by scipy, without events."""
        def rates(_: float, states: np.ndarray) -> np.ndarray:
            return self.at(self.states, states, self.rates)

        solved = solve_ivp(rates, (0.0, stop_time), self.get(self.states),
                           method="LSODA", rtol=1e-10, atol=1e-12)
        assert solved.success
        self.at(self.states, solved.y[:, -1], self.rates)
        return np.array(solved.y[:, -1])
