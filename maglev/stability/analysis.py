"""`region`: how large a step a limited loop takes, certified, simulated and flown, with and without antiwindup."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from maglev.errors import QuantityError, StabilityError
from maglev.linear.model import Matrix
from maglev.linear.parameters import Quantity
from maglev.stability.axis_loop import AxisLoop, axis_loop, rig_named
from maglev.stability.certificate import Certificate, certify, synthesise
from maglev.stability.flight import Flights
from maglev.stability.simulation import Response, largest_step, respond
from maglev.units import parse_quantity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DECAY = 1.0   # 1/s, that synthesised gains are to keep: half of the slowest poles of the thesis's faster gains

AS_SET, WITHOUT, SYNTHESISED = "as set", "without", "synthesised"


@dataclass(frozen=True, eq=False)
class Flown:
    """Steps flown by the FMUs.

    Attributes
    ----------
    response : Response
        Of the whole stage to the step of the region.
    held : bool
        Whether it ends within 1 mm of every reference, without having touched a stop.
    largest : float
        Largest step that is held, m.
    largest_locked : float or None
        The same with the gap held by force, m; None of a vertical axis.
    """

    response: Response
    held: bool
    largest: float
    largest_locked: float | None


@dataclass(frozen=True, eq=False)
class Candidate:
    """What one choice of antiwindup gains gives.

    Attributes
    ----------
    name : str
        "as set", "without" or "synthesised".
    certificate : Certificate
        Ellipsoid and largest certified step.
    simulated : float
        Largest step of the linear loop with its limit, m; LARGEST_STEP if every step comes back.
    response : Response
        Of that loop to the step of the region.
    flown : Flown or None
        By the FMUs, if they were asked for.
    """

    name: str
    certificate: Certificate
    simulated: float
    response: Response
    flown: Flown | None

    @property
    def gains(self) -> Matrix:
        """Ec, shape (3,): m s²/A, m s/A, m/A."""
        return self.certificate.gains


@dataclass(frozen=True, eq=False)
class Region:
    """Stability of one limited axis about a gap.

    Attributes
    ----------
    loop : AxisLoop
        The linear loop and its limit.
    step : float
        Step of the responses, m.
    candidates : tuple of Candidate
        As set, without antiwindup, and synthesised, as far as there are such.
    """

    loop: AxisLoop
    step: float
    candidates: tuple[Candidate, ...]

    def __getitem__(self, name: str) -> Candidate:
        """Return the candidate of a name."""
        for each in self.candidates:
            if each.name == name:
                return each
        raise StabilityError(f"region: no candidate {name!r}, expected one of "
                             f"{', '.join(each.name for each in self.candidates)}")

    def __str__(self) -> str:
        """The region as text."""
        from maglev.stability.text import text_of

        return text_of(self)

    def as_data(self) -> dict[str, Any]:
        """Everything as JSON has it; SI."""
        from maglev.stability.text import data_of

        return data_of(self)

    def plot(self) -> "Figure":
        """Picture, a matplotlib Figure: certified ellipse and simulated states, and the responses."""
        from maglev.stability.pictures import figure_of

        return figure_of(self)


def region(rig: str, axis: str, gap: Quantity, *, controller: str | None = None,
           set: Mapping[str, Quantity | bool] | None = None, synthesise: bool = False, decay: float = DECAY,
           step: Quantity | None = None, fly: bool = False, fmus: str | Path = "fmus", native: bool = False) -> Region:
    """Say how large a step an axis takes although its command is limited, with and without antiwindup.

    Certified: an ellipsoid by linear matrix inequalities from which the linear loop comes back for certain. Simulated:
    the same loop, step by step. Flown: the FMUs. Needs cvxpy and Clarabel, the extra `region`.

    Parameters
    ----------
    rig : str
        "2dof" or "3dof".
    axis : str
        "v", "h" or "y", "x", "z".
    gap : float or str
        Air gap at which everything else rests, m or text such as "25 mm".
    controller : str, optional
        An output regulator; `Regulator2DOF` or `Regulator3DOF` if not given.
    set : mapping of str to value, optional
        Parameters by `plant.…` and `controller.…`, SI or text with a unit: {"controller.x.ec1": 2e-4}.
    synthesise : bool
        Also look for the antiwindup gains with the largest certified step.
    decay : float
        Rate at which, with these, states in the ellipsoid are to decay at least, 1/s.
    step : float or str, optional
        Step of the responses, m; the largest certified one of the first candidate if not given.
    fly : bool
        Also fly steps with the FMUs, a dozen or two for each candidate.
    fmus : path
        Folder with the FMUs of this project, which `build` makes.
    native : bool
        The FMUs that need no Python, of the folder's folder `native`.

    Raises
    ------
    StabilityError
        If there is nothing to certify, or no solver.
    LinearModelError
        If the stage cannot rest at this gap, or a parameter cannot be used.

    Examples
    --------
    >>> import maglev
    >>> found = maglev.region("3dof", "x", "25 mm")
    >>> found["as set"].certificate.step > found["without"].certificate.step
    True
    """
    if not 0.0 <= decay < float("inf"):
        raise StabilityError(f"decay = {decay!r} 1/s, expected a finite rate of 0 1/s or more")
    asked = None if step is None else size_of(step)
    settings = by_fmu(set or {})
    loop = axis_loop(rig, axis, gap, controller=controller, plant_parameters=settings["plant"],
                     controller_parameters=settings["controller"])
    choices = {WITHOUT: np.zeros(3)}
    if loop.gains.any():
        choices = {AS_SET: loop.gains, **choices}
    if synthesise:
        choices[SYNTHESISED] = synthesised(loop, decay)
    certificates = {name: certify(loop, gains) for name, gains in choices.items()}
    shown = next(iter(certificates.values())).step if asked is None else asked
    flights = None
    if fly:
        ending, described = rig_named(rig)
        name = controller or f"Regulator{ending}"
        folder = Path(fmus) / "native" if native else Path(fmus)
        flights = [Flights(rig, axis, gap, name, settings["plant"], settings["controller"], folder, locked)
                   for locked in ([False] if axis == described.vertical else [False, True])]
    return Region(loop, shown, tuple(
        Candidate(name, each, largest_step(loop, each), respond(loop, each.gains, shown),
                  None if flights is None else flown(flights, axis, each.gains, shown))
        for name, each in certificates.items()))


def synthesised(loop: AxisLoop, decay: float) -> Matrix:
    """Antiwindup gains by the inequalities; under this name because `region` has an argument of the other."""
    return synthesise(loop, decay)


def flown(flights: list[Flights], axis: str, gains: Matrix, step: float) -> Flown:
    """Steps flown with antiwindup gains: with the gap free and, if there is a second, with the gap locked."""
    values: dict[str, float | bool] = {f"{axis}.ec{k}": float(gain) for k, gain in enumerate(gains, 1)}
    values["antiwindup"] = True   # gains of 0 are none, and the other axes keep theirs
    response, held = flights[0].fly(step, values)
    return Flown(response, held, flights[0].largest(values), flights[1].largest(values) if flights[1:] else None)


def size_of(step: Quantity) -> float:
    """Size of a step, m; StabilityError if it is none."""
    try:
        found = parse_quantity(step, "m")
    except QuantityError as error:
        raise StabilityError(f"step: {error}") from None
    if found <= 0.0:
        raise StabilityError(f"step = {found:g} m, expected one above 0 m")
    return found


def by_fmu(settings: Mapping[str, Quantity | bool]) -> dict[str, dict[str, Quantity | bool]]:
    """Parameters of plant and controller from names with a dot, such as "plant.y.mass"."""
    found: dict[str, dict[str, Quantity | bool]] = {"plant": {}, "controller": {}}
    for name, value in settings.items():
        part, dot, variable = name.partition(".")
        if part not in found or not dot:
            raise StabilityError(f"set {name}: expected plant.… or controller.…, such as controller.x.ec1")
        found[part][variable] = value
    return found
