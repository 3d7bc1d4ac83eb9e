"""The closed loop of a sampled plant and a controller, and the loop opened at one signal."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from maglev.errors import LinearModelError, nearest
from maglev.linear.linearise import linearise
from maglev.linear.margins import Margins, margins_of
from maglev.linear.model import Complex, LinearModel
from maglev.linear.parameters import CONTROLLERS, PLANTS, Quantity


@dataclass(frozen=True, eq=False)
class Loop:
    """A sampled plant and a controller that measures its positions and commands its currents.

    A controller of one's own is a `LinearModel` as well: sampled as the plant, with inputs "<axis>.measured" and any
    others, and outputs that are called like the plant's inputs.

    Attributes
    ----------
    plant, controller : LinearModel
        The plant's outputs are the positions of its axes.

    Raises
    ------
    LinearModelError
        If they do not fit: sample times differ, or a measurement or command has no counterpart.
    """

    plant: LinearModel
    controller: LinearModel

    def __post_init__(self) -> None:
        plant, controller = self.plant, self.controller
        if plant.sample_time is None or plant.sample_time != controller.sample_time:
            raise LinearModelError(f"a loop of {plant.name}, sample time {plant.sample_time} s, and {controller.name}, "
                                   f"{controller.sample_time} s: expected the same sample time of both")
        for name in plant.inputs:
            controller.index("output", name)
        for name in self.measured:
            controller.index("input", name)

    @property
    def measured(self) -> tuple[str, ...]:
        """Inputs of the controller that the plant's positions go to."""
        return tuple(name.replace(".position", ".measured") for name in self.plant.outputs)

    @property
    def references(self) -> tuple[str, ...]:
        """The other inputs of the controller."""
        return tuple(name for name in self.controller.inputs if name not in self.measured)

    @property
    def openings(self) -> tuple[str, ...]:
        """Where the loop can be opened: every measured position and every command."""
        return (*self.measured, *self.plant.inputs)

    @property
    def closed(self) -> LinearModel:
        """The closed loop, from references to positions."""
        controller = self.controller.select((*self.references, *self.measured), self.plant.inputs)
        r = len(self.references)
        a = np.block([[self.plant.A + self.plant.B @ controller.D[:, r:] @ self.plant.C, self.plant.B @ controller.C],
                      [controller.B[:, r:] @ self.plant.C, controller.A]])
        b = np.vstack([self.plant.B @ controller.D[:, :r], controller.B[:, :r]])
        c = np.hstack([self.plant.C, np.zeros((len(self.plant.outputs), len(controller.states)))])
        states = (*self.plant.states, *(self.state_name(name) for name in controller.states))
        units = {**self.plant.units, **self.controller.units,
                 **{self.state_name(name): self.controller.units[name] for name in controller.states}}
        return LinearModel(f"{self.plant.name} with {self.controller.name}", states, self.references,
                           self.plant.outputs, a, b, c, np.zeros((len(c), r)), units,
                           self.plant.sample_time, self.plant.equilibrium)

    @property
    def poles(self) -> Complex:
        """Poles of the closed loop in the z-plane."""
        return self.closed.poles

    @property
    def rates(self) -> Complex:
        """Poles of the closed loop as rates ln(z)/Ts, 1/s, the slowest first."""
        return self.closed.rates

    @property
    def stable(self) -> bool:
        """Whether every pole of the closed loop is inside the unit circle."""
        return bool((np.abs(self.poles) < 1.0).all())

    def opened(self, at: str) -> LinearModel:
        """Return the loop opened at one signal, all others closed, as the L of 1 + L.

        Parameters
        ----------
        at : str
            A measured position such as "y.measured", or just the axis: all that takes the measurement is opened, the
            law and the commutation of its commands. Or a command such as "alpha.i_q_cmd", before the commutation,
            which keeps the true displacement.

        Raises
        ------
        LinearModelError
            If there is no such signal.
        """
        name = self.opening(at)
        plant, controller, closed = self.plant, self.controller.select(self.measured, self.plant.inputs), self.closed
        if name in self.measured:
            k = self.measured.index(name)
            # Two take a measurement: the law, and the commutation of its commands.
            by_measured = controller.D + (0.0 if plant.commutation is None else plant.commutation)
            b = np.vstack([plant.B @ by_measured[:, k:k + 1], controller.B[:, k:k + 1]])
            c = np.hstack([plant.C[k:k + 1], np.zeros((1, len(controller.states)))])
        else:
            k = plant.inputs.index(name)
            b = np.vstack([plant.B[:, k:k + 1], np.zeros((len(controller.states), 1))])
            c = np.hstack([controller.D[k:k + 1] @ plant.C, controller.C[k:k + 1]])
        # What goes in at the opening comes back as −L times it: the feedback is negative in 1 + L.
        returned = f"{name}.returned"
        return LinearModel(f"{closed.name}, opened at {name}", closed.states, (name,), (returned,), closed.A - b @ c, b,
                           -c, np.zeros((1, 1)), {**closed.units, returned: closed.units[name]}, closed.sample_time,
                           closed.equilibrium)

    def margins(self, at: str) -> Margins:
        """Margins of the loop opened at one signal, a name as of `opened`; its errors, and one if it is unstable."""
        if not self.stable:
            worst = max(self.poles, key=abs)
            raise LinearModelError(f"{self.closed.name}: a pole at |z| = {abs(worst):.6f}, expected a stable loop for "
                                   "margins")
        return margins_of(self.opened(at), self.opening(at))

    def opening(self, at: str) -> str:
        """Full name of the signal at which a user opens the loop."""
        for name in (at, f"{at}.measured", f"{at}_cmd"):
            if name in self.openings:
                return name
        raise LinearModelError(f"{self.closed.name}: no signal {at!r} to open the loop at, expected one of "
                               f"{', '.join(self.openings)}; nearest is {nearest(at, self.openings)}")

    def state_name(self, name: str) -> str:
        """Name of a state of the controller in the closed loop."""
        return f"controller.{name}"


def linearise_loop(plant: str, controller: str | LinearModel, at: Mapping[str, Quantity], *, amplifier: bool = True,
                   plant_parameters: Mapping[str, Quantity | bool] | None = None,
                   controller_parameters: Mapping[str, Quantity | bool] | None = None) -> Loop:
    """Linearise a plant and a controller where the plant rests, and close the loop.

    The loop is the sampled one that the master steps: measurement at t_k, phase currents commutated with it and held
    until t_k + Ts.

    Parameters
    ----------
    plant : str
        "Plant2DOF" or "Plant3DOF".
    controller : str or LinearModel
        One of the controllers, or a sampled linear model of one's own (see `Loop`).
    at : mapping of str to float or str
        Position of each axis, as of `linearise`.
    amplifier : bool
        Whether the plant has the lag of its amplifiers.
    plant_parameters, controller_parameters : mapping, optional
        Parameters that differ from their start values.

    Raises
    ------
    LinearModelError
        As of `linearise` and `Loop`.

    Examples
    --------
    >>> loop = linearise_loop("Plant3DOF", "Regulator3DOF", {"y": "25 mm"})
    >>> loop.stable
    True
    """
    if plant not in PLANTS:
        raise LinearModelError(f"{plant!r} is no plant, expected one of {', '.join(PLANTS)}; nearest is "
                               f"{nearest(plant, PLANTS)}")
    settings: dict[str, Any] = {"amplifier": amplifier, "parameters": plant_parameters}
    rest = linearise(plant, at, **settings).equilibrium
    if isinstance(controller, str):
        if controller not in CONTROLLERS:
            raise LinearModelError(f"{controller!r} is no controller with a linear model, expected one of "
                                   f"{', '.join(CONTROLLERS)}; nearest is {nearest(controller, CONTROLLERS)}")
        controller = linearise(controller, rest, parameters=controller_parameters)
    elif controller_parameters:
        raise LinearModelError(f"{controller.name}: controller_parameters = {dict(controller_parameters)}, expected "
                               "none with a linear model")
    if controller.sample_time is None:
        raise LinearModelError(f"{controller.name}: continuous in time, expected a sampled controller")
    return Loop(linearise(plant, rest, hold=controller.sample_time, **settings), controller)
