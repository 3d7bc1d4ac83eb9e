"""Check that a stage can run, and its consequences: constants, currents, times, margins over the travel, warnings."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import degrees, inf, log10, sqrt
from pathlib import Path
from statistics import fmean as mean
from typing import Any

from maglev.descriptions.registry import known_stages
from maglev.files.arrays import Array
from maglev.files.errors import LinearModelError, StageError
from maglev.files.text_columns import aligned, in_width
from maglev.files.toml_file import read_toml
from maglev.files.units import parse_quantity
from maglev.fmi.parameter import Parameter
from maglev.linear.equilibrium import equilibrium
from maglev.linear.loop import Loop, linearise_loop
from maglev.linear.margins import Margins
from maglev.linear.parameters import linear_names
from maglev.user import gain_design as design
from maglev.user.adoption import know_stage
from pmlsm.gap_functions import gap_functions
from pmlsm.stage_description import StageAxis, StageDescription
from pmlsm.velocity_rows import GRAVITY

LEAST_PHASE = 35.0   # degrees
LEAST_GAIN = 6.0     # dB
HEAD = 18            # letters, of a line
LONGEST_FALL = 10.0  # s, beyond which a mover without current counts as balanced


@dataclass(frozen=True)
class Place:
    """A stage at one air gap.

    Attributes
    ----------
    gap : float
        m.
    currents : dict of str to float
        i_d that hold the mover, A, by motor, as the controllers' model has it; none where none do.
    closing, opening : float
        Net force on the mover at the limits of i_d, N: the most that closes the gap, and that opens it. The smaller one
        is the reserve to hold it; a force below 0 N is missing.
    margins : dict of str to (float, float)
        Phase margin (degrees) and smaller gain margin (dB) at the measurement of each axis, with all others closed:
        exact for plant, hold, lag, observer and law.
    """

    gap: float
    currents: dict[str, float]
    closing: float
    opening: float
    margins: dict[str, tuple[float, float]]


@dataclass(frozen=True)
class Consequences:
    """Consequences of the description of a stage.

    Attributes
    ----------
    stage : Stage
    forces : dict of str to float
        At the start: of all motors, thrust per current by axis and normal force by i_d in N/A, attraction in N.
    limits : dict of str to float
        Largest i_d, A, by motor: of the regulators, and of the amplifiers for a short time.
    fall : float
        Time without current from the start to a stop, s; inf where it is balanced.
    rate : float
        Of the fastest unstable pole at the start, 1/s.
    wanted : float
        Sample time by which sampling costs at most 5° of phase, s.
    places : tuple of Place
        The start, and both ends of travel.
    sheet : str
        The data sheet's numbers for rms currents, converted for peak currents; empty if it states peaks.
    """

    stage: StageDescription
    forces: dict[str, float]
    limits: dict[str, float]
    fall: float
    rate: float
    wanted: float
    places: tuple[Place, Place, Place]
    sheet: str = ""

    def __repr__(self) -> str:
        return f"<Consequences of {self.brief}>"

    def resting(self, place: Place) -> dict[str, float]:
        """Currents (A) at a place by their names, such as "left.i_d", or as "i_d" where all motors have the same."""
        alike = all(len({f"{current:.3g}" for current in place.currents.values()}) <= 1 for place in self.places)
        return {"i_d" if alike else f"{motor}.i_d": current for motor, current in place.currents.items()}

    def most(self, current: str) -> tuple[float, float]:
        """The most (A) of a current by its name, and for good."""
        motors = [motor for motor in self.stage.motors if current in ("i_d", f"{motor.name}.i_d")]
        return (min(self.limits[motor.name] for motor in motors),
                min(motor.amplifier.continuous or inf for motor in motors))

    @property
    def warnings(self) -> list[str]:
        """Warnings about obstacles to its good work, each with the necessary change."""
        stage, vertical = self.stage, self.stage.vertical.name
        texts = []
        if stage.sample_time > 2.0 * design.longest_sample_time(stage):
            texts.append(f"sample_time: {1e3 * stage.sample_time:g} ms costs more than 10° of phase, expected "
                         f"{1e3 * self.wanted:g} ms or less")
        for place in self.places:
            at = f"{vertical} = {1e3 * place.gap:.4g} mm"
            if not place.currents:
                texts.append(f"{at}: no direct current holds the mover, expected stops further apart from it, a "
                             "lighter attraction or a heavier mover")
                continue
            currents = self.resting(place)
            name, current = max(currents.items(), key=lambda item: abs(item[1]) / self.most(item[0])[0])
            beyond = [motor for motor, value in currents.items() if abs(value) > self.most(motor)[1]]
            if min(place.closing, place.opening) <= 0.0:
                texts.append(f"{at}: {name} = {current:.3g} A holds the mover, expected less than "
                             f"{self.most(name)[0]:.3g} A: a larger limit or amplifier, stops nearer to the start, or "
                             "another mass")
            elif beyond:
                texts.append(f"{at}: {beyond[0]} = {currents[beyond[0]]:.3g} A holds the mover, the amplifiers give "
                             f"continuously {self.most(beyond[0])[1]:.3g} A: stops nearer to the start, or another "
                             "mass")
        for axis in self.stage.axis_names:
            met = [(min(margins[0] / LEAST_PHASE, margins[1] / LEAST_GAIN), *margins, place.gap)
                   for place in self.places if (margins := place.margins.get(axis)) is not None]
            share, phase, gain, gap = min(met, default=(1.0, inf, inf, 0.0))
            if share < 1.0:
                texts.append(f"{vertical} = {1e3 * gap:.4g} mm: {axis} has margins of {phase:.0f}° and {gain:.1f} dB, "
                             f"expected {LEAST_PHASE:g}° and {LEAST_GAIN:g} dB: leave the gains to the design, or "
                             "take a shorter sample_time or faster amplifiers")
        return texts

    @property
    def brief(self) -> str:
        """The most of it in one line."""
        stage, start = self.stage, self.places[0]
        margins = [margin for place in self.places for margin in place.margins.values()]
        least = f"{min(phase for phase, _ in margins):.0f}°, {min(gain for _, gain in margins):.1f} dB"
        return (f"{stage.title}: {stage.vertical.mass:g} kg at {1e3 * start.gap:g} mm, {self.at_rest}, unstable pole "
                f"{self.rate:.3g} 1/s, sample time "
                f"{1e3 * stage.sample_time:g} ms, margins {least} or more; `maglev stage` says more")

    @property
    def at_rest(self) -> str:
        """Currents at the start, and their limits."""
        return ", ".join(f"{name} = {current:.3g} A of at most {self.most(name)[0]:.3g} A" + (
                             f" ({self.most(name)[0] / sqrt(2.0):.3g} A rms)" if self.sheet else "")
                         for name, current in self.resting(self.places[0]).items())

    def __str__(self) -> str:
        """All of it within 80 columns: a subject a line, a table with a column for each place, and warnings."""
        stage, start = self.stage, self.places[0]
        forces = ", ".join(f"{name} {value:.4g} {'N' if name == 'attraction' else 'N/A'}"
                           for name, value in self.forces.items())
        constants = ", ".join(f"{constant.name} = {constant.plant:.4g}" for constant in stage.constants)
        subjects = {
            "constants": f"{constants} (docs/equations.md)",
            **{motor.name: f"{', '.join(f'{ratio:.4g}' for ratio in motor.ratios)} times these: thrust, attraction, "
               "coils, iron" for motor in stage.unlike},
            "motors": f"{forces}, at the start, a gap of {1e3 * start.gap:g} mm, per ampere of peak current",
            **({"data sheet": self.sheet} if self.sheet else {}),
            "current at rest": self.at_rest,
            "without current": "it is balanced" if self.fall == inf else
                               f"{1e3 * self.fall:.3g} ms from the start to a stop",
            "unstable pole": f"{self.rate:.3g} 1/s",
            "sample time": f"{1e3 * stage.sample_time:g} ms, wanted {1e3 * self.wanted:g} ms or less",
            "observers": f"{1e3 * stage.design.observer_time:g} ms",
            **{f"gains of {axis.name}": ", ".join(f"{gain:.6g}" for gain in axis.design.gains) for axis in stage.axes}}
        return "\n".join([
            f"{stage.title}: {stage.vertical.mass:g} kg at a gap of {1e3 * start.gap:g} mm",
            *(in_width(subject.ljust(HEAD), text) for subject, text in subjects.items()),
            "", aligned(self.table), *([""] if self.warnings else []),
            *(in_width("warning: ", warning) for warning in self.warnings)]) + "\n"

    @property
    def table(self) -> list[list[str]]:
        """Cells of the values at each place, a row for each quantity."""
        rows = [["gap", *(f"{1e3 * place.gap:.4g} mm" for place in self.places)]]
        for name in self.resting(self.places[0]):
            currents = [self.resting(place).get(name) for place in self.places]
            rows.append([name, *("none" if current is None else f"{current:.3g} A" for current in currents)])
        rows.append(["force left over", *(f"{min(place.closing, place.opening):.3g} N" for place in self.places)])
        for axis in self.places[0].margins:
            margins = [place.margins.get(axis) for place in self.places]
            rows.append([f"margins of {axis}", *("–" if of is None else f"{of[0]:.0f}°, {of[1]:.1f} dB"
                                                 for of in margins)])
        return rows

    def as_data(self) -> dict[str, Any]:
        """All of it as JSON has it, SI."""
        return {"stage": self.stage.name,
                "constants": {constant.name: constant.plant for constant in self.stage.constants},
                "forces": self.forces, "limits": self.limits, "fall": None if self.fall == inf else self.fall,
                "rate": self.rate, "sample_time": self.stage.sample_time, "wanted_sample_time": self.wanted,
                "observer_time": self.stage.design.observer_time,
                "gains": {axis.name: list(axis.design.gains) for axis in self.stage.axes},
                "places": [asdict(place) for place in self.places], "warnings": self.warnings}


def stage(path: str | Path) -> Consequences:
    """Return the consequences of the description of a stage, NAME.toml.

    Raises
    ------
    StageError, ScenarioError
        If it is no description, or no stage that can work, with the necessary change.

    Examples
    --------
    >>> import maglev
    >>> description, _ = maglev.new_stage("lifted.toml", motor=["small"])
    >>> found = maglev.stage(description)
    >>> found.places[0].margins["v"][0] > 35.0
    True
    """
    stage = runnable(path)
    gap, *ends = design.gap_travel(stage)
    inward = 1e-6 * (ends[1] - ends[0])   # a stop itself is touched
    forces = {f"thrust {axis.name}": axis.mass * stage.sharing * stage.model.thrust[axis.name] * sum(
        motor.ratios[0] * gap_functions(stage.motor(motor), gap)[0] for motor in stage.motors_of(axis.name))
        for axis in stage.horizontal}
    for name in ("coils", "attraction"):
        forces["normal" if name == "coils" else name] = stage.vertical.mass * mean(
            getattr(pull, name) for pull in design.pulls(stage, gap))
    places = (place_at_gap(stage, gap), place_at_gap(stage, ends[0] + inward), place_at_gap(stage, ends[1] - inward))
    return Consequences(stage, forces, dict(zip(stage.motor_names, design.current_limits(stage), strict=True)),
                        fall(stage),
                        design.unstable_rate(stage), design.wanted_sample_time(stage), places,
                        peaks_of(read_toml(Path(path)), gap))


def peaks_of(description: Mapping[str, Any], start: float) -> str:
    """Return a data sheet's numbers for rms currents, converted for peak currents; empty if it states peaks."""
    sheet = description.get("catalogue", {})
    if sheet.get("currents") != "rms":
        return ""
    peak, force = (None if key not in sheet else parse_quantity(sheet[key], unit)
                   for key, unit in (("peak", "A"), ("force_constant", "N/A")))
    gap = parse_quantity(sheet.get("at", start), "m")
    return "; ".join([
        *([] if peak is None else [f"peak of {peak:.4g} A rms = {sqrt(2.0) * peak:.3g} A"]),
        *([] if force is None else [f"force constant of {force:.4g} N/A rms = {force / sqrt(2.0):.4g} N per ampere of "
                                    f"peak current, of one motor at a gap of {1e3 * gap:g} mm"])])


def place_at_gap(stage: StageDescription, gap: float) -> Place:
    at = design.held(stage, gap)
    closing, opening = (stage.vertical.mass * acceleration
                        for acceleration in design.vertical_accelerations(stage, gap))
    if at is None:
        return Place(gap, {}, closing, opening, {})
    lifted = {f"{motor}.amplifier.{key}": value for motor in stage.motor_names
              for key, value in (("peak", 1e3), ("continuous", 0.0))}
    try:
        loop = linearise_loop(f"Plant{stage.suffix}", f"Regulator{stage.suffix}", {stage.vertical.name: gap, **{
            axis.name: axis.start for axis in stage.horizontal}}, plant_parameters=lifted,
            controller_parameters={"current_limit": 0.0})
    except LinearModelError:   # the stage itself is not held where its model is
        return Place(gap, {}, closing, opening, {})
    currents = {motor: held.current for motor, held in zip(stage.motor_names, at, strict=True)}
    return Place(gap, currents, closing, opening, {axis: margins_at(loop, axis) for axis in stage.axis_names})


def margins_at(loop: Loop, axis: str) -> tuple[float, float]:
    """Phase (degrees) and gain (dB) of the loop opened at a measurement; 0 of a loop that is unstable."""
    if not loop.stable:
        return 0.0, 0.0
    margins: Margins = loop.margins(axis)
    down = -20.0 * log10(margins.gain_down) if margins.gain_down > 0.0 else inf
    return degrees(margins.phase), min(20.0 * log10(margins.gain_up), down)


def fall(stage: StageDescription) -> float:
    """Time (s) in which the mover without current goes from its start to a stop; inf if it takes very long."""
    from scipy.integrate import solve_ivp

    stop = stage.gap_stop
    ends = [lambda t, state, end=end: state[0] - end for end in (stop.lower, stop.upper)]
    for event in ends:
        event.terminal = True   # type: ignore[attr-defined]  # where scipy looks

    def rates(_: float, state: Array) -> list[float]:
        return [state[1], GRAVITY - mean(pull.attraction for pull in design.pulls(stage, state[0]))]

    done = solve_ivp(rates, (0.0, LONGEST_FALL), [stage.vertical.start, 0.0], events=ends, rtol=1e-8, atol=1e-12)
    return min((float(times[0]) for times in done.t_events or () if len(times)), default=inf)


def runnable(path: str | Path) -> StageDescription:
    """Read a description and check that its stage can run.

    StageError, ScenarioError if it is not a description. StageError also if stops are outside the field's range, no
    current below the limits holds the mover at its start, or thrust does not overcome bias and friction. Also if
    sampling is too slow for the unstable pole, or the loop of a regulator is unstable. The messages have the numbers.
    """
    stage = know_stage(path)
    try:
        require_field(stage)
        require_within_ranges(stage)
        start = {axis.name: axis.start for axis in stage.axes}
        for kind in ("Plant", "Regulator"):
            equilibrium(f"{kind}{stage.suffix}", start)
        for axis in stage.horizontal:
            require_thrust(stage, axis)
        rate = design.unstable_rate(stage)
        if rate * stage.sample_time > design.SLOWEST_SAMPLING:
            raise StageError(f"sample_time: {1e3 * stage.sample_time:g} ms, expected at most "
                             f"{1e3 * design.SLOWEST_SAMPLING / rate:.3g} ms: without control the mover leaves its "
                             f"start with exp({rate:.3g} t/s)")
        loop = linearise_loop(f"Plant{stage.suffix}", f"Regulator{stage.suffix}", start)
        if not loop.stable:
            raise StageError(f"design: the loop has a pole of magnitude {max(abs(loop.poles)):.4g} per sample of "
                             f"{1e3 * stage.sample_time:g} ms, expected all below 1: change gains, poles or "
                             f"sample_time; without control the mover leaves with exp({rate:.3g} t/s)")
    except (StageError, LinearModelError) as error:
        raise StageError(f"{path}: {error}") from None
    return stage


def require_field(stage: StageDescription) -> None:
    stop, fields = stage.gap_stop, [stage.motor(motor).field for motor in stage.motors]
    lower, upper = max(field.lower for field in fields), min(field.upper for field in fields)
    if not lower <= stop.lower < stop.upper <= upper:
        place = "motor_stop" if stage.rotations else f"axes.{stage.vertical.name}.stop"
        raise StageError(f"{place}: from {1e3 * stop.lower:g} to {1e3 * stop.upper:g} mm, expected "
                       f"within {1e3 * lower:g}…{1e3 * upper:g} mm, where the field is known")


def require_within_ranges(stage: StageDescription) -> None:
    """Raise for values that no FMU takes as a start value."""
    for definition in map(known_stages().definition, linear_names(stage)):
        block = definition.new_block()
        for variable in definition.variables:
            if variable.causality == "parameter" and not variable.boolean:
                Parameter.of(variable).read(variable.read(block), f"{definition.name}: {variable.name}",
                                            StageError)


def require_thrust(stage: StageDescription, axis: StageAxis) -> None:
    needed, given = abs(axis.bias) + axis.friction.coulomb / axis.mass, design.strongest(stage, axis.name)
    if given <= needed:
        raise StageError(f"axes.{axis.name}: its motors give {axis.mass * given:.3g} N at their limit and the start "
                         f"gap, but bias and friction take {axis.mass * needed:.3g} N, expected more thrust")
