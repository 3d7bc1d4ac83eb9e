"""Gains of a stage: from poles, or designed on its linear model with lag, hold and observer in the loop."""

from collections.abc import Sequence
from math import inf, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from controller_fmu.feedback_linearisation import smaller_root
from controller_fmu.internal_model import OscillatorStep
from controller_fmu.velocity_observer import ObserverFilter
from maglev.descriptions.data_sheet import twelve_digits
from maglev.files.arrays import Array, Complex
from maglev.files.errors import StageError
from maglev.linear.design import gains_of
from maglev.linear.places import MotorPlaces
from pmlsm.gap_functions import gap_functions
from pmlsm.gap_slopes import gap_slopes
from pmlsm.stage_description import StageAxis, StageDescription, StageMotor
from pmlsm.velocity_rows import GRAVITY

OMEGA0 = 1.5 * pi   # rad/s, of the internal models

# Poles of the design by their rate: a fast pair, and slow ones by which the internal model settles. These are not far
# slower than its own sinusoid, or every step swings in it first.
FAST = (0.9, 0.436)
SLOW, SLOWEST = 0.15, 0.5
BANDWIDTH = 0.7     # of the three poles of the controller that a user begins with, by the rate of the fast pair

# A disk margin α keeps a loop stable under factors of (2 − α)/(2 + α) to its inverse and angles of 2 atan(α/2): 6 dB
# and 36.9° at 2/3. More is wanted, for encoders, friction and the motion of other axes are not in the model.
DISK = 0.85
RATES = np.geomspace(1.2, 5.0, 16)                    # of the fast pair, by how fast the mover leaves its place
SLOWER = np.geomspace(1.0, 0.1, 16)                   # shares of the rate wanted of an axis that stays in place
SHORTEST_WAY = 1e-9  # m, for which it is to be fast: an axis may begin at its stop
OBSERVER_TIMES = (1e-3, 5e-4, 3e-4, 2e-4, 1e-4, 5e-5)   # s
FREQUENCIES = 200
LOWEST = 0.2        # rad/s
SLOWEST_SAMPLING = 0.25   # samples in which the mover's distance may grow by e: with fewer, no designed gains hold it
# Phase that hold and sampling cost a designed loop, which crosses over at about 4.2 times the rate of the unstable
# pole: 5° for a sample and a half.
WANTED_SAMPLING = 5.0 * pi / 180.0 / (1.5 * 4.2)


def gains_of_poles(place: str, given: Any) -> list[float]:
    """Gains k1…k5 that place five poles: real ones as numbers, a pair as [real, imaginary part] (rad/s).

    StageError if there are not five, or one is not on the left.
    """
    poles: list[complex] = []
    for entry in given if isinstance(given, list) else []:
        pair = entry if isinstance(entry, list) else [entry, None]
        if len(pair) != 2 or not all(isinstance(part, (int, float)) or part is None for part in pair):
            poles = []
            break
        poles += [pair[0]] if pair[1] is None else [complex(*pair), complex(pair[0], -pair[1])]
    if len(poles) != 5 or any(complex(pole).real >= 0.0 for pole in poles):
        raise StageError(f"{place}: {given!r}, expected five poles with real parts below 0, such as "
                       "[-90, [-4, 6], [-2, 2]]: a number, or real and imaginary part of a pair")
    return [twelve_digits(gain) for gain in gains_of(np.poly(np.array(poles)).real.tolist(), OMEGA0)]


class Held(NamedTuple):
    """A motor of the model's mover at a gap where direct currents hold it level."""

    current: float     # A, i_d
    stiffness: float   # α, 1/s², of the air gap while the currents stay, if all motors were as this one: δ'' = α δ
    f1: float


class Pull(NamedTuple):
    """Normal forces of a motor at a gap, as accelerations if all motors were as this one: those of (4.3), (5.3)."""

    share: float        # of the weight that it carries, of n motors n times that
    attraction: float   # m/s²
    coils: float        # m/(s² A)
    iron: float         # m/(s² A²)
    constants: tuple[float, ...]   # these three over the shape functions

    @property
    def missing(self) -> float:
        """Share of the attraction that the current has to remove (m/s²)."""
        return self.attraction - self.share * GRAVITY


def pulls(stage: StageDescription, gap: float) -> list[Pull]:
    """Normal forces of the model's motors at a gap (m); each carries what keeps the mover level."""
    of, places = stage.model, MotorPlaces.of(stage)
    level = len(stage.motors) * np.linalg.pinv(places.gaps)[0] if stage.rotations else np.ones(len(stage.motors))
    all_pulls = []
    for motor, share in zip(stage.motors, level.tolist(), strict=True):
        _, f2, f3, f4 = gap_functions(stage.motor(motor), gap)
        attraction, coils, iron = constants = tuple(stage.carrying * constant * ratio for constant, ratio in zip(
            (of.attraction, of.coils, of.iron), motor.ratios[1:], strict=True))
        all_pulls.append(Pull(share, attraction * f2, coils * f3, iron * f4, constants))
    return all_pulls


def held(stage: StageDescription, gap: float) -> list[Held] | None:
    """The motors as the model has them at a gap (m); None where no direct currents hold the mover."""
    currents = []
    for motor, pull in zip(stage.motors, pulls(stage, gap), strict=True):
        current, there = smaller_root(pull.iron, pull.coils, pull.missing)
        if not there or pull.coils <= 2.0 * pull.iron * current:
            return None
        geometry = stage.motor(motor)
        by_attraction, by_coils, by_iron = (constant * slope for constant, slope in zip(
            pull.constants, gap_slopes(geometry, gap), strict=True))
        currents.append(Held(current, by_coils * current - by_iron * current * current - by_attraction,
                             gap_functions(geometry, gap)[0]))
    return currents


def gap_travel(stage: StageDescription) -> tuple[float, float, float]:
    """Air gaps (m): the start, and both ends of the travel between the stops."""
    return stage.vertical.start, stage.gap_stop.lower, stage.gap_stop.upper


def stiffness(stage: StageDescription, axis: str, at: list[Held]) -> float:
    """Return α (1/s²) of an axis at constant currents, δ'' = α δ, positive if it leaves its place.

    Horizontally the phase currents hold the field, and the mover with it where i_d is below 0 (2.1).
    """
    places, k = MotorPlaces.of(stage), stage.axis_names.index(axis)
    if stage.axis(axis) in stage.horizontal:
        thrust = stage.sharing * stage.model.thrust[axis]
        return sum(thrust * motor.ratios[0] * pull.f1 * stage.motor(motor).wave_number * pull.current
                   for motor, pull in zip(stage.motors, at, strict=True) if motor.drives == axis)
    alphas = np.array([held.stiffness for held in at])
    return float(places.effects[k, 0::2] * alphas @ places.gaps[:, k]) / len(stage.motors)


def uncontrolled(stage: StageDescription) -> list[str]:
    """Axes along which the mover leaves its place if nothing controls it: the air gap, and tilts of it."""
    return [stage.vertical.name, *(axis.name for axis in stage.rotations)]


def unstable_rate(stage: StageDescription) -> float:
    """Rate (1/s) with which the mover leaves its start, where the model's motors hold it, if nothing controls it.

    StageError if no direct current holds it there.
    """
    start = held(stage, stage.vertical.start)
    if start is None:
        gap, vertical = stage.vertical.start, stage.vertical
        attracted = sum(pull.attraction for pull in pulls(stage, gap)) / len(stage.motors)
        raise StageError(f"no direct current holds the mover of {vertical.mass:g} kg at {1e3 * gap:g} mm: the motors "
                         f"attract it by {attracted:.3g} m/s² against 9.81 m/s² of gravity, expected another "
                       "gap, mass or attraction")
    return sqrt(max(1e-6, *(stiffness(stage, axis, start) for axis in uncontrolled(stage))))


def strongest(stage: StageDescription, axis: str) -> float:
    """Acceleration (m/s²) of a horizontal axis by its motors at the start gap and the current that they may have.

    All have the same thrust.
    """
    motors = [motor for motor in stage.motors if motor.drives == axis]
    by_motor = [motor.ratios[0] * gap_functions(stage.motor(motor), stage.vertical.start)[0] * min(
        motor.amplifier.continuous or motor.amplifier.peak, limit_of(stage, motor)) for motor in motors]
    return stage.sharing * stage.model.thrust[axis] * len(motors) * min(by_motor)


def limit_of(stage: StageDescription, motor: StageMotor) -> float:
    """Largest current (A) of a motor that the regulators command."""
    return (stage.design.current_limit or inf) * (1.0 if motor.kind is None else motor.kind.limit)


def current_limits(stage: StageDescription) -> list[float]:
    """Largest direct current (A) of each motor: of the regulators, and of the amplifiers for a short time."""
    return [min(limit_of(stage, motor), motor.amplifier.peak) for motor in stage.motors]


def vertical_accelerations(stage: StageDescription, gap: float) -> tuple[float, float]:
    """Largest accelerations (m/s²) that close a gap (m) and that open it, level, with direct currents up to a limit."""
    closing, opening = [], []
    for pull, limit in zip(pulls(stage, gap), current_limits(stage), strict=True):
        most = min(limit, pull.coils / (2.0 * pull.iron))   # beyond, the iron is attracted by more than the coils push
        ends = sorted(force / pull.share for force in (
            -(pull.iron * limit * limit + pull.coils * limit + pull.missing),
            pull.coils * most - pull.iron * most * most - pull.missing))
        closing.append(-ends[0])
        opening.append(ends[1])
    return min(closing), min(opening)


def feasible_steps(stage: StageDescription) -> dict[str, float]:
    """Step (m, rad) for which gains ask for half of the force left over at the start, horizontally for all of it."""
    vertical = min(vertical_accelerations(stage, stage.vertical.start))
    errors = {}
    for axis in stage.axes:
        given = 2.0 * strongest(stage, axis.name) if axis in stage.horizontal else max(vertical, 0.0)
        if axis.rotation:
            given *= stage.vertical.mass * stage.arm / axis.mass / sqrt(len(stage.motors))
        errors[axis.name] = 0.5 * given / max(abs(axis.design.gains[0]), 1e-9)
    return errors


def longest_sample_time(stage: StageDescription) -> float:
    """Sample time (s) by which sampling costs the fastest axis 5° of phase; StageError as in `unstable_rate`."""
    alphas = [stiffness(stage, axis, at) for gap in gap_travel(stage) if (at := held(stage, gap)) is not None
              for axis in uncontrolled(stage)]
    return WANTED_SAMPLING / max(unstable_rate(stage), sqrt(max(0.0, *alphas)))


def wanted_sample_time(stage: StageDescription) -> float:
    """The next shorter sample time (s) of 1, 2 or 5 times a power of ten; StageError as in `unstable_rate`."""
    longest = longest_sample_time(stage)
    decade = 10.0 ** np.floor(np.log10(longest))
    return float(f"{max(step for step in (1.0, 2.0, 5.0) if step * decade <= longest) * decade:.3g}")


class DelayedAxis(NamedTuple):
    """An axis with the lag of its amplifiers, sampled, as its measurement sees it: δ'' = α δ + a, a → v − α δ.

    The law gives the acceleration v. Its measurement also goes into the feedback linearisation of the air gap, and
    horizontally into the commutation; both cancel the stiffness α where the mover is.
    """

    rates: Array       # rad/s, that come into question for the fast poles, the first that of a stage without delays
    best: bool         # true if the rate with the largest margin is wanted, not the first with enough
    places: tuple[tuple[float, Complex], ...]   # α (1/s²), and δ by a at the frequencies, wherever it can be

    def disk(self, law: Complex) -> float:
        """Smallest disk margin of all places under a law, v by δ at the frequencies.

        A loop that is unstable has one, too: laws that come into question are stable without delays, and lose what
        they have of it before they are not.
        """
        loops = [-plant * (law - alpha) for alpha, plant in self.places]
        return float(1.0 / max(np.abs(1.0 / (1.0 + loop) - 0.5).max() for loop in loops))

    def rate(self, terms: Complex) -> tuple[float, float]:
        """Rate (rad/s) for the fast poles under a regulator's terms (see `law_terms`), and its margin."""
        best = (float(self.rates[0]), 0.0)
        for rate in self.rates.tolist():
            margin = self.disk(terms @ weights(gains_at_rate(rate)))
            if margin > best[1]:
                best = rate, margin
            if margin >= DISK and not self.best:
                break
        return best


def delayed(stage: StageDescription, axis: StageAxis, z: Complex) -> DelayedAxis:
    """An axis at frequencies exp(jωTs), with rates that come into question.

    A horizontal axis that nothing drives off its place is as fast as its motors can make it over a tenth of its way.
    """
    alphas = [stiffness(stage, axis.name, at) for gap in gap_travel(stage) if (at := held(stage, gap)) is not None]
    leaving = sqrt(max([*alphas, 1e-6]))
    rates = leaving * RATES
    if axis in stage.horizontal:
        assert axis.stop is not None   # as the reader of descriptions sees to
        way = max(0.1 * min(axis.start - axis.stop.lower, axis.stop.upper - axis.start), SHORTEST_WAY)
        wanted = max(sqrt(strongest(stage, axis.name) / (2.0 * way)), rates[0])
        rates = np.concatenate([wanted * SLOWER[SLOWER * wanted >= leaving], rates])
    if leaving * stage.sample_time > SLOWEST_SAMPLING:
        return DelayedAxis(rates[:1], True, ())   # refused where it is to run
    lag = max(motor.amplifier.lag for motor in stage.motors)
    places = tuple((alpha, response(alpha, lag, stage.sample_time, z)) for alpha in alphas)
    return DelayedAxis(rates, axis not in stage.horizontal, places)


def frequencies(sample_time: float) -> Complex:
    """Frequencies at which margins are looked at, as z = exp(jωTs)."""
    z: Complex = np.exp(1j * np.geomspace(LOWEST, max(pi / sample_time, LOWEST), FREQUENCIES) * sample_time)
    return z


def response(alpha: float, lag: float, sample_time: float, z: Complex) -> Complex:
    """δ by the commanded a of δ'' = α δ + a, sampled with hold, at z."""
    from scipy.linalg import expm  # commands that design nothing start without it

    rate = 1.0 / max(lag, 1e-3 * sample_time)
    # [δ, δ', a, command]
    step = expm(sample_time * np.array([[0.0, 1.0, 0.0, 0.0], [alpha, 0.0, 1.0, 0.0], [0.0, 0.0, -rate, rate],
                                        [0.0, 0.0, 0.0, 0.0]]))
    return transfer(step[:3, :3], step[:3, 3:], z)[:, 0]


def transfer(a: Array, b: Array, z: Complex) -> Complex:
    """States by the one input of a sampled system at z, shape (frequencies, states)."""
    resolvent = z[:, None, None] * np.eye(len(a)) - a
    return np.asarray(np.linalg.solve(resolvent, np.broadcast_to(b, (len(z), *b.shape)))[..., 0], np.complex128)


def law_terms(observer_time: float, sample_time: float, z: Complex) -> Complex:
    """Terms of the demand of the output regulator (4.16) by its measurement at z, sampled as its blocks do.

    Measurement, velocity, ξ1, ξ2, ξ3: shape (frequencies, 5).
    """
    observer, step = ObserverFilter(), OscillatorStep()
    observer.time1 = observer.time2 = observer_time
    observer.prepare(sample_time)
    step.prepare(OMEGA0, sample_time)
    share = observer.share1
    velocity = (share / (1.0 - (1.0 - share) / z)) ** 2 * (1.0 - 1.0 / z) / sample_time
    internal = transfer(np.array([[1.0, step.sine, step.versine], [0.0, step.cosine, step.sine],
                                  [0.0, step.minus_sine, step.cosine]]),
                        np.array([[step.ramp], [step.versine], [step.sine]]), z)
    return np.column_stack([np.ones(len(z)), velocity, internal])


def weights(gains: Sequence[float]) -> Array:
    """Weights of these terms under gains k1…k5."""
    return np.array([*gains[:2], gains[2] + 1.0, *gains[3:]])


def gains_at_rate(rate: float) -> tuple[float, ...]:
    """Gains k1…k5 for a fast pair of poles at a rate (rad/s), and three slow ones."""
    slow = min(max(SLOW * rate, OMEGA0), SLOWEST * rate)
    fast = rate * complex(*FAST)
    poles = [-fast, -fast.conjugate(), -slow, -slow * (0.8 + 0.6j), -slow * (0.8 - 0.6j)]
    return tuple(twelve_digits(gain) for gain in gains_of(np.poly(np.array(poles)).real.tolist(), OMEGA0))


def axis_design(stage: StageDescription, axis: StageAxis, rate: float) -> dict[str, Any]:
    """Values of the design of an axis, by name, for the rate (rad/s) of its fast poles."""
    bandwidth = twelve_digits(BANDWIDTH * rate)
    # Steps of gap and tilts share the currents of the motors: without a pre-filter they end on the stops.
    tilting = stage.rotations and axis not in stage.horizontal
    return {"gains": gains_at_rate(rate), "bandwidth": bandwidth,
            "pid": (-SLOW * rate, -FAST[0] * rate, FAST[1] * rate),
            "prefilter": min(bandwidth, 1.0 / stage.sample_time) if tilting else 0.0}


@np.errstate(all="ignore")   # a value that is no number is no margin
def designed_rates(stage: StageDescription, axes: Sequence[str], observer_time: float | None) -> tuple[float,
                                                                                                       dict[str,
                                                                                                            float],
                                                                                                            float]:
    """Rates from which the gains of axes follow, by the disk margin that they leave over the travel of the air gap.

    Time constant of the observers (s), a given one or the longest that leaves enough; rates (rad/s) of the fast poles
    by axis; the smallest disk margin.
    """
    z = frequencies(stage.sample_time)
    loops = {axis: delayed(stage, stage.axis(axis), z) for axis in axes}
    best = (0.0, 0.0, {axis: twelve_digits(float(loop.rates[0])) for axis, loop in loops.items()})
    if not all(loop.places for loop in loops.values()):
        return (OBSERVER_TIMES[0] if observer_time is None else observer_time), best[2], 0.0
    for time in OBSERVER_TIMES if observer_time is None else (observer_time,):
        terms = law_terms(time, stage.sample_time, z)
        rates = {axis: loop.rate(terms) for axis, loop in loops.items()}
        margin = min(margin for _, margin in rates.values())
        if margin > best[0] or best[1] == 0.0:
            best = margin, time, {axis: twelve_digits(rate) for axis, (rate, _) in rates.items()}
        if margin >= DISK:
            break
    return best[1], best[2], best[0]
