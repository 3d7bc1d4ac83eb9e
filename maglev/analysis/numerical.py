"""`linearise_numerically`: the linear loop of any plant and controller, by differences of their responses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np

from maglev.analysis.pair import SETTLE, AskedPair, Pair, Rest, Settings, apart, make_pair, resting_pair, with_fmus
from maglev.analysis.participant import Derivative, Sign, derivative, no_sign
from maglev.analysis.realisation import Realisation, misfit, realise, translated_realisation
from maglev.cosim.isolated_run import TIMEOUT
from maglev.files.arrays import Array
from maglev.files.errors import LinearModelError
from maglev.files.text_columns import aligned
from maglev.linear.equilibrium import check_amplifiers
from maglev.linear.loop import Loop, opening_among
from maglev.linear.margins import Margins
from maglev.linear.model import Equilibrium, LinearModel
from maglev.linear.parameters import Quantity, block_of
from maglev.linear.plant_model import linear_plant
from maglev.user.source import Given

PUSH, CURRENT = 1e-6, 1e-3      # m or rad, A: sizes of the pushes on inputs
CONTROLLER_SECONDS = 0.6        # s of a controller's response: an internal model of 4.7 rad/s turns by half a circle
PLANT_SECONDS = 0.1             # s of a plant's: left alone it falls
WIDTH = 80
MISFIT = 1e-4                   # of responses; with a larger one no state space is returned


@dataclass(frozen=True, eq=False)
class NumericalLoop:
    """A loop by differences.

    Attributes
    ----------
    pair : Pair
    derivatives : tuple of Derivative
        Of the controller with respect to each of its inputs, and of a third-party plant with respect to the commands.
    loop : Loop or None
        None where a derivative does not exist.
    rough : Loop or None
        The same by the smaller pushes alone: the difference shows the error.
    misfit : float
        Difference of the responses of the state space from the recorded ones, relative to the largest.
    means : str
        Way of bringing the controller back to its point: by its state or by its past.
    moving : float
        Motion of the measurements in the last half second before that, m or rad.
    exact : bool
        True if the controller's matrices are derivatives of its code; otherwise they are made of the responses.
    """

    pair: Pair
    derivatives: tuple[Derivative, ...]
    loop: Loop | None
    rough: Loop | None
    misfit: float
    means: str
    moving: float
    exact: bool = False

    def __repr__(self) -> str:
        return f"<NumericalLoop {self.pair.name}: {self.why_not or 'linear'}>"

    @property
    def why_not(self) -> str:
        """Return the reason if there is no linear loop, else an empty text."""
        return "; ".join(f"{slope.name} has no derivative here: {slope.verdict}" for slope in self.derivatives
                         if slope.verdict) or (
            "" if self.loop is not None else
            f"no linear system of few states has its responses; the best one differs by {self.misfit:.2g}")

    def linear(self) -> Loop:
        """The loop; LinearModelError says why there is none."""
        if self.loop is None:
            raise LinearModelError(f"{self.pair.name}: {self.why_not}; expected a smooth law; `maglev linearise "
                                   "--measure` measures any law")
        return self.loop

    def margins(self, at: str) -> Margins:
        """Return the margins of the loop opened at a signal; see `Loop.margins`."""
        return self.linear().margins(at)

    def errors(self, at: str) -> dict[str, float]:
        """Estimated errors of the numbers in `margins`, by their names."""
        margins = self.margins(at)
        assert self.rough is not None
        rough = vars(self.rough.margins(at))
        return {name: 0.0 if value == rough[name] else abs(value - rough[name])
                for name, value in vars(margins).items() if isinstance(value, float)}

    def __str__(self) -> str:
        """Return the table of the derivatives, and the quality of the state space."""
        rows = [["derivative with respect to", "error", "holds to", ""]]
        for slope in self.derivatives:
            unit, by = ("mA", 1e3) if slope.name.endswith("_cmd") else ("µm", 1e6)
            rows.append([slope.name, "none", "", ""] if slope.verdict else
                        [slope.name, f"{slope.error:.1e}", f"{by * slope.holds_to:g}", unit])
        text = aligned(rows)
        for slope in self.derivatives:
            if slope.verdict:
                text += "\n" + fill(f"{slope.name} has no derivative here: {slope.verdict}", WIDTH)
        if self.loop is not None:
            by_code = ", exact, by the derivative of its code," if self.exact else ""
            text += "\n" + fill(f"{len(self.loop.controller.states)} states of the controller{by_code} with responses "
                                f"within {self.misfit:.1e} of those run from {self.means}; at rest within "
                                f"{1e6 * self.moving:.2g} µm", WIDTH)
        return text

    def as_data(self) -> dict[str, Any]:
        """Return it in JSON form."""
        return {"derivatives": [{"input": slope.name, "error": slope.error, "holds_to": slope.holds_to,
                                 "verdict": slope.verdict} for slope in self.derivatives],
                "misfit": self.misfit, "moving": self.moving, "means": self.means, "exact": self.exact,
                "controller": None if self.loop is None else self.loop.controller.as_data(),
                "plant": None if self.loop is None else self.loop.plant.as_data()}


def linearise_numerically(plant: str | Path, controller: Given, at: Mapping[str, Quantity], *,
                          openings: Sequence[str] = (), references: bool = True, settle: float = SETTLE,
                          fmus: str | Path | None = None,
                          kind: str | None = None, fmi: int = 2, ports: str | Path | None = None,
                          plant_parameters: Settings | None = None, controller_parameters: Settings | None = None,
                          sample_time: Quantity | None = None, stage: str | Path | None = None,
                          timeout: float = TIMEOUT) -> NumericalLoop:
    """Linearise the loop of any controller and any plant about its point of rest.

    The loop runs until it rests, without Coulomb friction and rounding where the plant has parameters for them. There
    each input of the controller is pushed for one sample, up and down, by several sizes, and a state space is made of
    the responses. The controller only has to return to that point, by its own saved state or by its past. For a Python
    class in the subset of native FMUs, the state space is exact: the derivative of its code, checked against the
    responses. A plant of this project is linearised from its equations, see `linearise`; any other like the
    controller.

    Parameters
    ----------
    openings : sequence of str
        Signals at which the loop will be opened; an unknown one raises an error before the run.
    references : bool
        Also take references and their rates as inputs of the linear controller, with its measurements.
    settle : float
        Longest run of the loop before the pushes, s.
    timeout : float
        Longest time that a step of a third-party FMU may take, s; it runs in a process of its own.
    plant, controller, at, ports, plant_parameters, controller_parameters, sample_time, stage, fmus, kind, fmi
        See `AskedPair`, and `run` for the last three.

    Returns
    -------
    NumericalLoop
        A controller without a derivative has one, too, with the reason and the signal.

    Raises
    ------
    LinearModelError, FmuError, ControllerError, ScenarioError
        See `make_pair` and `resting_pair`.
    """
    asked = with_fmus(AskedPair(plant, controller, at, Path(), ports, plant_parameters, controller_parameters,
                                sample_time, stage), openings, True, fmus, kind, fmi)
    return apart(linearised_here, asked.sources, timeout, asked, openings, references, settle)


def linearised_here(asked: AskedPair, openings: Sequence[str], references: bool, settle: float,
                    sign: Sign = no_sign) -> NumericalLoop:
    pair = make_pair(asked)
    for name in openings:
        opening_among(name, (*pair.openings, *pair.commands), pair.name)
    with resting_pair(pair, settle, sign=sign) as rest:
        return linearised(rest, references, asked.plant_parameters or {})


def linearised(rest: Rest, references: bool, plant_parameters: Settings) -> NumericalLoop:
    pair, part = rest.pair, rest.controller
    base = np.array([*rest.measured, *pair.references.values()])
    samples = max(200, round(CONTROLLER_SECONDS / pair.step))
    slopes: list[Derivative] = []
    for number in range(len(base) if references else len(rest.measured)):
        slopes.append(derivative(part, base, number, PUSH, samples, check=number < len(rest.measured)))
        if slopes[-1].verdict:   # the long responses of the others would be for nothing
            return NumericalLoop(pair, tuple(slopes), None, None, np.inf, part.means, rest.moving)
    inputs = part.inputs[:len(slopes)]
    responses, coarse = (np.stack([getattr(slope, kind) for slope in slopes], axis=2)
                         for kind in ("response", "coarse"))
    code = translated_realisation(part, base, len(slopes))
    apart = np.inf if code is None else misfit(*code[0][:4], responses)
    exact = code is not None and apart <= MISFIT
    if code is not None and exact:
        ways = [(code[0]._replace(misfit=apart), code[1])] * 2
    else:
        ways = [(realise(answers), ()) for answers in (responses, coarse)]
    (controller, worst), (rough, _) = (
        named_model(inputs, pair.commands, pair.controller_name, pair, rest.equilibrium, "A", *way) for way in ways)
    stages, by_current = stages_of(rest, plant_parameters)
    derivatives = (*slopes, *by_current)
    worst = max(worst, *(stage[1] for stage in stages))
    if worst > MISFIT or any(slope.verdict for slope in derivatives):
        return NumericalLoop(pair, derivatives, None, None, worst, part.means, rest.moving)
    return NumericalLoop(pair, derivatives, Loop(stages[0][0], controller), Loop(stages[-1][0], rough), worst,
                         part.means, rest.moving, exact)


def named_model(inputs: tuple[str, ...], outputs: tuple[str, ...], name: str, pair: Pair, equilibrium: Equilibrium,
                unit: str, realised: Realisation, states: tuple[str, ...] = ()) -> tuple[LinearModel, float]:
    """A realisation with its names, and its misfit; the states are numbered if they have none."""
    states = states or tuple(f"x{k}" for k in range(1, len(realised.A) + 1))
    units = {**dict.fromkeys(states, ""), **dict.fromkeys(outputs, unit),
             **{name: "A" if name.endswith("_cmd") else "m/s" if name.endswith("rate") else "m" for name in inputs}}
    return LinearModel(name, states, inputs, outputs, realised.A, realised.B, realised.C, realised.D, units, pair.step,
                       equilibrium), realised.misfit


def stages_of(rest: Rest, parameters: Settings) -> tuple[list[tuple[LinearModel, float]], tuple[Derivative, ...]]:
    """Return the plant at rest: of this project from its equations; any other by differences, also roughly."""
    pair = rest.pair
    if pair.own_plant is not None:
        block = block_of(pair.own_plant, parameters)
        check_amplifiers(pair.name, block, rest.equilibrium)
        return [(linear_plant(pair.own_plant, pair.stage, block, rest.equilibrium, True, True, False, pair.step),
                 0.0)], ()
    samples = max(100, round(PLANT_SECONDS / pair.step))
    slopes = tuple(derivative(rest.plant, rest.commanded, number, CURRENT, samples)
                   for number in range(len(pair.commands)))
    outputs = tuple(name.replace(".gap_encoder", ".gap").replace(".encoder", ".position")
                    for name in pair.signals.values())
    stages = []
    for kind in ("response", "coarse"):
        responses = np.stack([getattr(slope, kind) for slope in slopes], axis=2)
        # The outputs of a plant after a step are measured at the next sample.
        later: Array = np.concatenate([np.zeros((1, *responses.shape[1:])), responses])
        stages.append(named_model(pair.commands, outputs, pair.plant_name, pair, rest.equilibrium, "m", realise(later)))
    return stages, slopes
