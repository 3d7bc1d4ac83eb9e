"""The closed loop of a sampled plant and a controller, and the loop opened at one signal, also as pictures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from maglev.files.arrays import Array, Complex
from maglev.files.errors import LinearModelError, one_of, or_of_own_stage
from maglev.files.pictures import FAINT, new_figure, write_figure
from maglev.linear.controller_model import behind, commanded
from maglev.linear.equilibrium import equilibrium_of, model_of, read_positions
from maglev.linear.linearise import Currents, linearise
from maglev.linear.margins import Margins, frequencies_of, margins_of
from maglev.linear.model import LinearModel
from maglev.linear.parameters import Quantity, block_of, controllers, measurements, plants
from maglev.linear.plant_model import at_rest
from pmlsm.stage_description import StageDescription

JUMP = 1.5     # rad, of phase between neighbouring frequencies
WIDEST = 4.0   # of the Nyquist picture to either side: the part near −1 counts


@dataclass(frozen=True, eq=False)
class Loop:
    """A sampled plant and a controller that measures its positions and commands its currents.

    Your own controller is a `LinearModel` as well, sampled as the plant. It has inputs "<axis>.measured", or
    "<motor>.gap_measured" where the platform tilts, and any others. Its outputs have the names of the plant's inputs.

    Attributes
    ----------
    plant, controller : LinearModel
        The plant's outputs are the positions of its axes, and where the platform tilts, the gaps at the motors.

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
        axes = len(plant.equilibrium.positions)   # the first states; other readings of encoders need no measurement
        if np.linalg.matrix_rank(self.sensed[:, :axes]) < np.linalg.matrix_rank(plant.C[:, :axes]):
            for name in self.measured:
                controller.index("input", name)

    def __repr__(self) -> str:
        return f"<Loop of {self.plant!r} and {self.controller!r}>"

    @property
    def measured(self) -> tuple[str, ...]:
        """Measurement of each axis; on a tilting platform the gaps at the motors have some of them."""
        return tuple(f"{axis}.measured" for axis in self.plant.equilibrium.positions
                     if f"{axis}.position" in self.plant.outputs)

    @property
    def signals(self) -> dict[str, str]:
        """Outputs of the plant by the inputs of the controller that they go to, of the encoders where there are any."""
        names = {measured_as(output): output for output in self.plant.outputs}
        return {name: output for name, output in names.items() if name in self.controller.inputs}

    @property
    def sensed(self) -> Array:
        """Signals by the states of the plant, shape (signals, states)."""
        return self.plant.select(self.plant.inputs, tuple(self.signals.values())).C

    @property
    def references(self) -> tuple[str, ...]:
        """The other inputs of the controller."""
        return tuple(name for name in self.controller.inputs if name not in self.signals)

    @property
    def openings(self) -> tuple[str, ...]:
        """Signals at which the loop can be opened: measurements of every axis, all other measurements, and commands."""
        return (*dict.fromkeys((*self.measured, *self.signals)), *self.plant.inputs)

    @property
    def closed(self) -> LinearModel:
        """The closed loop, from references to positions."""
        controller = self.controller.select((*self.references, *self.signals), self.plant.inputs)
        r, sensed = len(self.references), self.sensed
        a = np.block([[self.plant.A + self.plant.B @ controller.D[:, r:] @ sensed, self.plant.B @ controller.C],
                      [controller.B[:, r:] @ sensed, controller.A]])
        b = np.vstack([self.plant.B @ controller.D[:, :r], controller.B[:, :r]])
        c = np.hstack([self.plant.C, np.zeros((len(self.plant.outputs), len(controller.states)))])
        states = (*self.plant.states, *(f"controller.{name}" for name in controller.states))
        units = {**self.plant.units, **self.controller.units,
                 **{f"controller.{name}": self.controller.units[name] for name in controller.states}}
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
        """Return True if every pole of the closed loop is inside the unit circle."""
        return bool((np.abs(self.poles) < 1.0).all())

    def opened(self, at: str) -> LinearModel:
        """Return the loop opened at one signal, all others closed, as the L of 1 + L.

        Parameters
        ----------
        at : str
            A measured position such as "y.measured", or just the axis: all that takes the measurement is opened, the
            law and the commutation of its commands. Where it is in the gaps at the motors, such as "roll.measured",
            these are opened together, each as far as the axis moves it; "alpha1.gap_measured" opens one alone. Or a
            command such as "alpha.i_q_cmd", before the commutation, which keeps the true displacement.

        Raises
        ------
        LinearModelError
            If there is no such signal.
        """
        name = self.opening(at)
        plant, closed, sensed = self.plant, self.closed, self.sensed
        controller = self.controller.select(tuple(self.signals), plant.inputs)
        if name in plant.inputs:
            k = plant.inputs.index(name)
            b = np.vstack([plant.B[:, k:k + 1], np.zeros((len(controller.states), 1))])
            c = np.hstack([controller.D[k:k + 1] @ sensed, controller.C[k:k + 1]])
        else:
            read, changed = self.measurement(name)
            # Two take a measurement: the law, and the commutation of its commands.
            by_signal = controller.D
            if plant.commutation is not None:
                by_signal = by_signal + plant.commutation @ plant.C @ np.linalg.pinv(sensed)
            b = np.vstack([plant.B @ by_signal @ changed, controller.B @ changed])
            c = np.hstack([read @ sensed, np.zeros((1, len(controller.states)))])
        # A signal at the opening comes back as −L times itself: the feedback is negative in 1 + L.
        returned, unit = f"{name}.returned", closed.units[name.replace(".measured", ".position")]
        return LinearModel(f"{closed.name}, opened at {name}", closed.states, (name,), (returned,), closed.A - b @ c, b,
                           -c, np.zeros((1, 1)), {**closed.units, name: unit, returned: unit},
                           closed.sample_time, closed.equilibrium)

    def measurement(self, name: str) -> tuple[Array, Array]:
        """Return a measurement in terms of the signals, and its effect on them; shapes (1, signals), (signals, 1)."""
        signals = tuple(self.signals)
        if name in signals:
            one = np.eye(len(signals))[:, signals.index(name):signals.index(name) + 1]
            return one.T, one
        position = name.replace(".measured", ".position")
        output = self.plant.C[self.plant.index("output", position)]
        moved = self.sensed[:, self.plant.index("state", position)]
        axes = len(self.plant.equilibrium.positions)
        return (output[:axes] @ np.linalg.pinv(self.sensed[:, :axes]))[None], moved[:, None]

    def margins(self, at: str) -> Margins:
        """Margins of the loop opened at one signal; for name and errors see `opened`; an error if it is unstable."""
        if not self.stable:
            worst = max(self.poles, key=abs)
            raise LinearModelError(f"{self.closed.name}: a pole at |z| = {abs(worst):.6f}, expected a stable loop for "
                                   "margins")
        return margins_of(self.opened(at), self.opening(at))

    def opening(self, at: str) -> str:
        """Full name of the signal at which a user opens the loop."""
        return opening_among(at, self.openings, self.closed.name)


def opening_among(at: str, openings: Sequence[str], loop: str) -> str:
    """Full name of a signal at which a user opens a loop; LinearModelError if the loop cannot be opened there."""
    for name in (at, f"{at}.measured", f"{at}.gap_measured", f"{at}_cmd"):
        if name in openings:
            return name
    raise LinearModelError(f"{loop}: no signal {at!r} to open the loop at, expected {one_of(at, openings)}")


def openings_of(stage: StageDescription, currents: Currents) -> tuple[str, ...]:
    """Return where a loop of a stage with such currents as commands can be opened, as in `Loop.openings`."""
    phases = ("i_d", "i_q") if currents == "dq" else ("i_a", "i_b", "i_c")
    return (*(f"{axis}.measured" for axis in stage.axis_names),
            *(f"{motor}.gap_measured" for motor in stage.motor_names if stage.rotations),
            *(f"{motor}.{phase}_cmd" for motor in stage.motor_names for phase in phases))


def measured_as(output: str) -> str:
    """The controller's name for the measurement of an output of the plant, such as "y.measured"."""
    for own, measured in ((".gap_encoder", ".gap_measured"), (".gap", ".gap_measured"), (".encoder", ".measured"),
                          (".position", ".measured")):
        if output.endswith(own):
            return output.removesuffix(own) + measured
    return output


def linearise_loop(plant: str, controller: str | LinearModel, at: Mapping[str, Quantity], *, amplifier: bool = True,
                   plant_parameters: Mapping[str, Quantity | bool] | None = None,
                   controller_parameters: Mapping[str, Quantity | bool] | None = None, measurement: str | None = None,
                   measurement_parameters: Mapping[str, Quantity | bool] | None = None) -> Loop:
    """Linearise a plant and a controller where the plant rests, and close the loop.

    The loop is the sampled one that the master steps: measurement at t_k, phase currents commutated with it and held
    until t_k + Ts. Where the platform tilts, more motors carry it than it takes: the currents of the equilibrium are
    those to which this controller comes.

    Parameters
    ----------
    plant : str
        Such as "Plant3DOF".
    controller : str or LinearModel
        One of the controllers, or a sampled linear model of one's own (see `Loop`).
    at : mapping of str to float or str
        Position of each axis, as in `linearise`.
    amplifier : bool
        True if the plant has the lag of its amplifiers.
    measurement : str, optional
        Such as "Measurement3DOF", between encoders and controller. The commands of its loop are phase currents: they
        are commutated with the measurements.
    plant_parameters, controller_parameters, measurement_parameters : mapping, optional
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
    for name, known, what in ((plant, plants(), "plant"), (measurement, measurements(), "measurement"),
                              (controller, controllers(), "controller with a linear model")):
        left_out = name is None and what == "measurement"
        if not (isinstance(name, LinearModel) or left_out or name in [*known]):
            raise LinearModelError(f"{name!r} is no {what}, expected {one_of(name, known, or_of_own_stage())}")
    currents: Currents = "dq" if measurement is None else "phases"
    split = None
    if isinstance(controller, str):
        split = model_of(controller, block_of(controller, controller_parameters or {}))
    stage = block_of(plant, plant_parameters or {})
    rest = equilibrium_of(plant, stage, read_positions(plant, at), split)
    if isinstance(controller, str):
        if rest.stage.unlike and not rest.stage.rotations:
            rest = commanded(controller, rest.stage, block_of(controller, controller_parameters or {}),
                             at_rest(rest.stage, stage, rest.positions), rest)
        controller = linearise(controller, rest, currents=currents, parameters=controller_parameters)
    elif controller_parameters:
        raise LinearModelError(f"{controller.name}: controller_parameters = {dict(controller_parameters)}: a linear "
                               "model takes no parameters")
    if controller.sample_time is None:
        raise LinearModelError(f"{controller.name}: continuous in time, expected a sampled controller")
    if measurement is not None:
        controller = behind(linearise(measurement, rest, parameters=measurement_parameters), controller)
    return Loop(linearise(plant, rest, currents=currents, amplifier=amplifier, hold=controller.sample_time,
                          parameters=plant_parameters), controller)


def write_bode(path: Path, loop: Loop, signals: tuple[str, ...]) -> None:
    """Write a PNG with gain and phase of the loop opened at each of the signals, and the gain of its sensitivity.

    Errors as in `Loop.opened`, and MaglevError without matplotlib.
    """
    figure = new_figure(8, 8)
    gain, phase, sensitivity = figure.subplots(3, 1, sharex=True)
    figure.suptitle(loop.closed.name)
    for signal in signals:
        opened = loop.opened(signal)
        frequencies = frequencies_of(opened)
        values = opened.frequency_response(frequencies)[:, 0, 0]
        gain.loglog(frequencies, np.abs(values), linewidth=1.0, label=loop.opening(signal))
        phase.semilogx(frequencies, np.degrees(np.unwrap(np.angle(values))), linewidth=1.0)
        sensitivity.loglog(frequencies, np.abs(1.0 / (1.0 + values)), linewidth=1.0)
    gain.axhline(1.0, **FAINT)
    sensitivity.axhline(1.0, **FAINT)
    gain.legend(fontsize="small")
    for panel, label in ((gain, "|L|"), (phase, "phase of L (°)"), (sensitivity, "|S| = |1/(1 + L)|")):
        panel.set_ylabel(label)
    sensitivity.set_xlabel("frequency (rad/s)")
    write_figure(path, figure)


def write_nyquist(path: Path, loop: Loop, signals: tuple[str, ...]) -> None:
    """Write a PNG with the Nyquist curve, near −1, of the loop opened at each of the signals.

    The radius of the circle about −1 is the distance that the largest peak of the sensitivity leaves. Errors as in
    `write_bode`, and LinearModelError if the loop is unstable.
    """
    figure = new_figure(7, 7)
    from matplotlib.patches import Circle  # an extra: only who plots needs it

    panel = figure.subplots()
    figure.suptitle(loop.closed.name)
    for signal in signals:
        opened = loop.opened(signal)
        values = opened.frequency_response(frequencies_of(opened))[:, 0, 0]
        # At a pole on the unit circle the curve goes through infinity: no line back.
        values[1:][np.abs(np.angle(values[1:] / values[:-1])) > JUMP] = np.nan
        line, = panel.plot(values.real, values.imag, linewidth=1.0, label=loop.opening(signal))
        panel.plot(values.real, -values.imag, linewidth=0.6, color=line.get_color(), linestyle="--")
    nearest = 1.0 / max(loop.margins(signal).sensitivity_peak for signal in signals)
    panel.add_patch(Circle((-1.0, 0.0), nearest, fill=False, **FAINT))
    panel.plot(-1.0, 0.0, "+", color="0.2")
    panel.set(xlim=(-WIDEST, WIDEST), ylim=(-WIDEST, WIDEST), aspect="equal", xlabel="Re L", ylabel="Im L")
    panel.legend(fontsize="small")
    write_figure(path, figure)
