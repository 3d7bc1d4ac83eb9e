"""`region`: how large a step a limited loop takes, certified, simulated and run, with and without antiwindup."""

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from maglev.analysis.axis_loop import axis_loop, currents_of, stage_and_regulators
from maglev.analysis.certificate import certify
from maglev.analysis.certificate import synthesise as synthesised_gains
from maglev.analysis.pair import Settings
from maglev.analysis.region_result import Candidate, Region, RunSteps
from maglev.analysis.region_simulation import SHOWN, Response, largest_step, respond
from maglev.files.arrays import Array
from maglev.files.errors import StabilityError, option
from maglev.files.units import parse_quantity, refused_as
from maglev.linear.equilibrium import read_positions
from maglev.linear.parameters import Quantity, block_of, by_part
from maglev.linear.places import MotorPlaces
from maglev.many.repeated_run import RepeatedRun
from maglev.runs.preparation import prepare
from maglev.scenario.fmus_for_runs import fmus_for_runs
from maglev.scenario.loading import load_plan
from maglev.scenario.quantities import printed
from maglev.user.scenario_loop import loop_table

DECAY = 1.0   # 1/s, that synthesised gains are to keep: half of the slowest poles of the thesis's faster gains

AS_SET, WITHOUT, SYNTHESISED = "as set", "without", "synthesised"
BEFORE = 1.0            # s, at rest before the step
HELD = 1e-3             # m, error at the end that counts as held, as in the scenarios; of a tilt at the outermost motor
NEAR_STOP = 0.5e-3      # m, that a run begins away from a stop
HALVINGS = 7


class StepRuns(RepeatedRun):
    """Steps of one axis of a stage, run one by one; a context manager that frees the FMUs.

    A horizontal axis steps from one side of the middle to the other, as far from the stops as possible. The vertical
    one steps to the gap (m or with a unit), a tilt to level. With `locked` the gap is held by force, as in the linear
    model of a horizontal axis. `plant` and `settings` are parameters of plant and controller.
    """

    def __init__(self, stage: str | Path, axis: str, gap: Quantity, controller: str, plant: Settings,
                 settings: Settings,
                 fmus: Path, locked: bool = False):
        self.stage, self.plant_name, _ = stage_and_regulators(stage)
        self.axis, self.vertical = axis, self.stage.vertical.name
        plant = {**plant, f"{self.vertical}.locked": True} if locked else plant
        self.middle = read_positions(self.plant_name, {self.vertical: gap})
        self.plant, dt = block_of(self.plant_name, plant), block_of(controller, settings).sample_time
        self.centred = axis in [axis.name for axis in self.stage.horizontal]
        self.before, count = round(BEFORE / dt), round((BEFORE + SHOWN) / dt)
        self.command = f"controller.{currents_of(self.stage, axis)[0]}_cmd"
        table = loop_table(self.stage) | {
            "name": "region", "title": "Steps of one axis", "step": dt, "output_interval": dt, "stop_time": count * dt,
            "fmus": {"controller": {"model": controller, "start": settings},
                     "plant": {"model": self.plant_name, "start": plant}},
            "signals": [{"to": f"controller.{name}.reference", "kind": "steps", "times": [0.0, self.before * dt],
                         "values": [position, position]} for name, position in self.middle.items()]}
        experiment = prepare(load_plan(table), fmus, {}, {})
        experiment.require_current()
        super().__init__(experiment, {*(f"plant.{name}.position" for name in self.stage.axis_names), self.command,
                                      "plant.at_stop"})

    def stops(self) -> tuple[float, float, float]:
        """Return the places where the axis meets its stops, at the motors if the platform tilts, and the margin for a
        start.
        """
        stage, plant, middle = self.stage, self.plant, self.middle[self.axis]
        if self.centred or not stage.rotations:
            stop = plant.axes[stage.axis_number(self.axis)].stop
            return stop.lower, stop.upper, NEAR_STOP
        shares = MotorPlaces.of(stage, plant).gaps[:, stage.axis_names.index(self.axis)]
        ways = [sorted((bound - self.middle[self.vertical]) / share for bound in (stop.lower, stop.upper))
                for stop, share in zip((mount.stop for mount in plant.mover.mounts), shares, strict=True)
                if share != 0.0]
        return (middle + max(way[0] for way in ways), middle + min(way[1] for way in ways),
                NEAR_STOP / float(np.abs(shares).max()))

    def room(self) -> tuple[float, float]:
        """Steps (m) that begin and end within the stops, downwards or to the left, and upwards or to the right."""
        lower, upper, near = self.stops()
        if not self.centred:
            end = self.middle[self.axis]
            return end + near - upper, end - near - lower
        reach = 2.0 * (min(-lower, upper) - near)
        return -reach, reach

    def respond(self, step: float, gains: Mapping[str, float | bool]) -> tuple[Response, bool]:
        """Response to a step (m) with antiwindup gains by their names, and whether the stage holds off its stops."""
        start = dict(self.middle)
        end = dict(self.middle)
        if not self.centred:
            start[self.axis] -= step
        else:
            start[self.axis], end[self.axis] = -0.5 * step, 0.5 * step
        lower, upper, _ = self.stops()
        if not lower < start[self.axis] < upper:
            unit = self.stage.axis(self.axis).unit("m")
            size, begin, low, high = (printed(value, unit) for value in (step, start[self.axis], lower, upper))
            raise StabilityError(f"{self.plant_name}: a step of {self.axis} by {size} begins at {begin}, expected a "
                                 f"start from {low} to {high}")
        changes: dict[str, float | bool] = {f"controller.{name}": gain for name, gain in gains.items()}
        for axis in self.middle:
            changes |= {f"plant.{axis}.position_start": start[axis], f"reference.{axis}.start": start[axis],
                        f"reference.{axis}.end": end[axis]}
        time, columns = self.run(changes)
        shown = slice(self.before, None)
        response = Response(step, time[shown] - time[self.before],
                            columns[f"plant.{self.axis}.position"][shown] - start[self.axis],
                            columns[self.command][shown].copy())
        ends = {axis.name: abs(columns[f"plant.{axis.name}.position"][-1] - end[axis.name])
                * (self.stage.arm if axis.rotation else 1.0) for axis in self.stage.axes}
        return response, bool(max(ends.values()) < HELD and not columns["plant.at_stop"].any())

    def largest(self, gains: Mapping[str, float | bool]) -> float:
        """Largest step, m, up to which halving finds every run held in both directions, within the stops."""
        found = []
        for reach in self.room():
            low, high = 0.0, reach
            if self.respond(reach, gains)[1]:
                low = reach
            else:
                for _ in range(HALVINGS):
                    middle = 0.5 * (low + high)
                    low, high = (middle, high) if self.respond(middle, gains)[1] else (low, middle)
            found.append(abs(low))
        return min(found)


def region(stage: str | Path, axis: str, gap: Quantity, *, controller: str | None = None,
           set: Mapping[str, Quantity | bool] | None = None, synthesise: bool = False, decay: float = DECAY,
           step: Quantity | None = None, run: bool = True, fmus: str | Path | None = None,
           kind: str | None = None, fmi: int = 2) -> Region:
    """Return the largest step that an axis takes with its limited command, with and without anti-windup.

    Certified: an ellipsoid by linear matrix inequalities from which the linear loop comes back for certain. Simulated:
    the same loop, step by step. Held: the FMUs, with friction, stops and a gap that moves, which the certificate
    leaves out: the stage may hold less than is certified. Needs cvxpy and Clarabel, the extra `region`.

    Parameters
    ----------
    stage : str or Path
        "2dof", "3dof", "5dof", or the description of your own stage, "mine.toml".
    axis : str
        "v", "h" or "y", "x", "z", or a tilt, whose lengths are in rad. Where the platform tilts, the certificate is
        also of the axes that the limits of the currents move; x and z take minutes.
    gap : float or str
        Air gap at which the other axes rest, m or text such as "25 mm".
    controller : str, optional
        An output regulator; the nonlinear one if not given.
    set : mapping of str to value, optional
        Parameters by `plant.…` and `controller.…`, SI or text with a unit: {"controller.x.ec1": 2e-4}.
    synthesise : bool
        Also look for the anti-windup gains with the largest certified step.
    decay : float
        Rate at which, with these, states in the ellipsoid are to decay at least, 1/s.
    step : float or str, optional
        Step of the responses, m; if not given, the largest certified one of the first candidate, or the largest within
        the stops.
    run : bool
        Also run steps with the FMUs, a dozen or two for each candidate; Python FMUs take a minute or two.
    fmus, kind, fmi
        See `run`.

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
    if decay != DECAY and not synthesise:
        raise StabilityError(f"decay = {decay!r} 1/s is for synthesised gains, needs {option('synthesise', True)}")
    settings = by_part(set or {}, StabilityError)
    loop = axis_loop(stage, axis, gap, controller=controller, plant_parameters=settings["plant"],
                     controller_parameters=settings["controller"])
    if step is not None:
        with refused_as(StabilityError, "step"):
            step = parse_quantity(step, loop.unit)
        if step <= 0.0:
            raise StabilityError(f"step = {step:g} {loop.unit}, expected one above 0 {loop.unit}")
    choices = {WITHOUT: np.zeros(3)}
    if loop.gains.any():
        choices = {AS_SET: loop.gains, **choices}
    if synthesise:
        choices[SYNTHESISED] = synthesised_gains(loop, decay)
    certificates = {name: certify(loop, gains) for name, gains in choices.items()}
    shown = next(iter(certificates.values())).step if step is None else step
    with ExitStack() as stack:
        runs: list[StepRuns] = []
        if run:
            described, _, regulators = stage_and_regulators(stage)
            name = controller or regulators[0]
            folder = fmus_for_runs([name, f"Plant{described.suffix}"], fmus, kind, fmi)
            # Where limits move other axes, too, the certificate is not of a loop at a frozen gap.
            gaps = [False] if axis == described.vertical.name or loop.axes[1:] else [False, True]
            runs = [stack.enter_context(StepRuns(stage, axis, gap, name, settings["plant"], settings["controller"],
                                                 folder, locked)) for locked in gaps]
            if step is None:
                shown = min(shown, runs[0].room()[1])
        return Region(loop, shown, tuple(
            Candidate(name, loop.unit, certificate, largest_step(loop, certificate),
                      respond(loop, certificate.gains, shown),
                      run_steps(runs, axis, certificate.gains, shown) if runs else None)
            for name, certificate in certificates.items()))


def run_steps(runs: list[StepRuns], axis: str, gains: Array, step: float) -> RunSteps:
    """Steps run with antiwindup gains: with the gap free and, if there is a second, with the gap locked."""
    values: dict[str, float | bool] = {f"{axis}.ec{k}": float(gain) for k, gain in enumerate(gains, 1)}
    values["antiwindup"] = True   # zero gains switch an axis's anti-windup off; the other axes keep theirs
    response, held = runs[0].respond(step, values)
    return RunSteps(response, held, runs[0].largest(values), runs[1].largest(values) if runs[1:] else None,
                 min(map(abs, runs[0].room())))
