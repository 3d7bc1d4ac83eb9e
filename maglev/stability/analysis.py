"""`region`: how large a step a limited loop takes, certified, simulated and run, with and without antiwindup."""

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from maglev.arrays import Array
from maglev.catalogue.for_runs import fmus_for_runs
from maglev.errors import StabilityError
from maglev.linear.parameters import Quantity, by_part
from maglev.schema.options import formerly
from maglev.stability.axis_loop import axis_loop, rig_named
from maglev.stability.certificate import certify
from maglev.stability.certificate import synthesise as synthesised_gains
from maglev.stability.flight import Flights
from maglev.stability.result import Candidate, Region, RunSteps
from maglev.stability.simulation import largest_step, respond
from maglev.units import parse_quantity, refused_as

DECAY = 1.0   # 1/s, that synthesised gains are to keep: half of the slowest poles of the thesis's faster gains

AS_SET, WITHOUT, SYNTHESISED = "as set", "without", "synthesised"


@formerly(stage="rig")
def region(stage: str, axis: str, gap: Quantity, *, controller: str | None = None,
           set: Mapping[str, Quantity | bool] | None = None, synthesise: bool = False, decay: float = DECAY,
           step: Quantity | None = None, run: bool = True, fmus: str | Path | None = None,
           kind: str | None = None, fmi: int = 2) -> Region:
    """Say how large a step an axis takes although its command is limited, with and without anti-windup.

    Certified: an ellipsoid by linear matrix inequalities from which the linear loop comes back for certain. Simulated:
    the same loop, step by step. Held: the FMUs, with friction, stops and a gap that moves, which the certificate
    leaves out: the stage may hold less than is certified. Needs cvxpy and Clarabel, the extra `region`.

    Parameters
    ----------
    stage : str
        "2dof", "3dof", "5dof", or the description of your own stage, "mine.toml".
    axis : str
        "v", "h" or "y", "x", "z", or a tilt, whose lengths are in rad. Where the platform tilts, the certificate is
        also of the axes that the limits of the currents move; x and z take minutes.
    gap : float or str
        Air gap at which everything else rests, m or text such as "25 mm".
    controller : str, optional
        An output regulator; the nonlinear one if not given.
    set : mapping of str to value, optional
        Parameters by `plant.…` and `controller.…`, SI or text with a unit: {"controller.x.ec1": 2e-4}.
    synthesise : bool
        Also look for the anti-windup gains with the largest certified step.
    decay : float
        Rate at which, with these, states in the ellipsoid are to decay at least, 1/s.
    step : float or str, optional
        Step of the responses, m; if not given, the largest certified one of the first candidate, or what the stops
        leave room for.
    run : bool
        Whether to run steps with the FMUs, a dozen or two for each candidate; Python FMUs take a minute or two.
    fmus, kind, fmi
        As of `run`.

    Raises
    ------
    StabilityError
        If there is nothing to certify, or no solver.
    LinearModelError
        If the stage cannot rest at this gap, or a parameter cannot be used.

    Examples
    --------
    >>> import maglev
    >>> found = maglev.region("3dof", "x", "25 mm", run=False)
    >>> found["as set"].certificate.step > found["without"].certificate.step
    True
    """
    if not 0.0 <= decay < float("inf"):
        raise StabilityError(f"decay = {decay!r} 1/s, expected a finite rate of 0 1/s or more")
    settings = by_part(set or {}, StabilityError)
    loop = axis_loop(stage, axis, gap, controller=controller, plant_parameters=settings["plant"],
                     controller_parameters=settings["controller"])
    asked = None if step is None else size_of(step, loop.unit)
    choices = {WITHOUT: np.zeros(3)}
    if loop.gains.any():
        choices = {AS_SET: loop.gains, **choices}
    if synthesise:
        choices[SYNTHESISED] = synthesised_gains(loop, decay)
    certificates = {name: certify(loop, gains) for name, gains in choices.items()}
    shown = next(iter(certificates.values())).step if asked is None else asked
    with ExitStack() as stack:
        flights: list[Flights] = []
        if run:
            described, _, regulators = rig_named(stage)
            name = controller or regulators[0]
            folder = fmus_for_runs([name, f"Plant{described.suffix}"], fmus, kind, fmi)
            # Where limits move other axes, too, the certificate is not of a loop at a frozen gap.
            gaps = [False] if axis == described.vertical.name or loop.axes[1:] else [False, True]
            flights = [stack.enter_context(Flights(stage, axis, gap, name, settings["plant"], settings["controller"],
                                                   folder, locked)) for locked in gaps]
            if asked is None:
                shown = min(shown, flights[0].room()[1])
        return Region(loop, shown, tuple(
            Candidate(name, loop.unit, certificate, largest_step(loop, certificate),
                      respond(loop, certificate.gains, shown),
                      run_steps(flights, axis, certificate.gains, shown) if flights else None)
            for name, certificate in certificates.items()))


def run_steps(flights: list[Flights], axis: str, gains: Array, step: float) -> RunSteps:
    """Steps run with antiwindup gains: with the gap free and, if there is a second, with the gap locked."""
    values: dict[str, float | bool] = {f"{axis}.ec{k}": float(gain) for k, gain in enumerate(gains, 1)}
    values["antiwindup"] = True   # gains of 0 are none, and the other axes keep theirs
    response, held = flights[0].respond(step, values)
    return RunSteps(response, held, flights[0].largest(values), flights[1].largest(values) if flights[1:] else None,
                 min(map(abs, flights[0].room())))


def size_of(step: Quantity, unit: str) -> float:
    """Size of a step, m or rad; StabilityError if it is none."""
    with refused_as(StabilityError, "step"):
        size = parse_quantity(step, unit)
    if size <= 0.0:
        raise StabilityError(f"step = {size:g} {unit}, expected one above 0 {unit}")
    return size
