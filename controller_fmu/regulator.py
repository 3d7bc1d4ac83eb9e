"""Regulator of any stage (4.15), (4.16), (5.13): output regulation, feedback-linearised or linearised."""

from math import pi
from typing import Any

from controller_fmu.described_platform import platform_of
from controller_fmu.fixed_gains import FixedGains
from controller_fmu.gain_schedule import GainSchedule
from controller_fmu.gain_table import GainTable
from controller_fmu.internal_model import OscillatorStep
from controller_fmu.level_platform import LevelPlatform
from controller_fmu.motor_command import MotorCommand
from controller_fmu.motor_model import MotorModel
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.own_currents import OwnCurrents
from controller_fmu.platform_forces import PlatformForces
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.sampled import Sampled
from controller_fmu.shared_current import SharedCurrent
from controller_fmu.status import (
    BAD_GEOMETRY,
    BAD_PLACES,
    INTERPOLATED,
    LINEAR,
    NO_EQUILIBRIUM,
    NONLINEAR,
    SCHEDULED,
    STEPPED,
)
from controller_fmu.velocity_observer import ObserverFilter
from pmlsm.stage_description import StageAxis, StageDescription


def axis_regulator(axis: StageAxis) -> OutputRegulator:
    """Return the output regulator of an axis, by its design."""
    k1, k2, k3, k4, k5 = axis.design.gains
    return OutputRegulator(k1, k2, k3, k4, k5, axis.design.antiwindup_gain, axis.start)


class Regulator(Sampled):
    """Samples positions and references, commands phase currents that hold until the next sample.

    The law is NONLINEAR: the motors are feedback-linearised at the measured gap (4.12), (5.7). Or LINEAR: they are
    linearised about the setpoint such that the closed loop has the same poles there (sections 4.6.1, 5.6.3). Or
    SCHEDULED: linear about the setpoint of the region that the measured gap lies in (Table 5.4). Or INTERPOLATED: about
    the equilibrium at the measured gap, from a fine table, with its current fed forward.

    Where the platform tilts, each motor has its own gap; the vertical axis and the tilts follow from the gaps.
    """

    def __init__(self, stage: StageDescription, law: int = NONLINEAR):
        design = stage.design
        rotations = len(stage.rotations)
        self.law = law
        self.model = MotorModel(stage)
        self.sample_time = stage.sample_time            # s, parameter
        self.omega0 = 1.5 * pi                        # rad/s, parameter
        self.setpoint = stage.vertical.start            # m, parameter of the linear law: gap of its linearisation
        self.bumpless = True                          # parameter of the linear law
        self.current_limit = design.current_limit     # A, parameter, 0 = none
        self.antiwindup = design.antiwindup           # parameter
        self.trip_error = 0.0                         # m, parameter, 0 = never
        self.trip_tilt = 0.0                          # rad, parameter, 0 = never
        self.observer = ObserverFilter(design.observer_time)
        self.oscillator = OscillatorStep()
        self.clock = SampleClock()
        # The vertical axis, the horizontal ones, the tilts.
        axes = (stage.vertical, *stage.horizontal, *stage.rotations)
        self.axes = [axis_regulator(axis) for axis in axes]
        self.tilted = [axis.rotation for axis in axes]                       # true if an axis is a tilt
        self.by_gap = [axis.rotation or axis is stage.vertical for axis in axes]   # true if a normal force serves it
        self.motors = [MotorCommand() for _ in stage.motors]
        # Of any type: the currents below know their type.
        self.platform: Any = platform_of(stage) if rotations else LevelPlatform()
        gains = (GainSchedule(design.schedule) if law == SCHEDULED and design.schedule is not None else
                 GainTable(design.table) if law == INTERPOLATED and design.table is not None else FixedGains())
        self.currents = (PlatformForces(stage, law, gains) if rotations else
                         OwnCurrents(stage, law) if stage.unlike else SharedCurrent(stage, law, gains))
        self.started = False    # state: a measurement has come in
        self.saturated = False  # output
        self.feasible = True    # output
        self.tripped = False    # state and output

    def start(self) -> int:
        """Compute what follows from the fixed parameters."""
        currents = self.currents
        model = self.model
        if not model.layout.prepare():
            return BAD_GEOMETRY
        self.observer.prepare(self.sample_time)
        self.oscillator.prepare(self.omega0, self.sample_time)
        if not self.platform.prepare():
            return BAD_PLACES
        currents.take_constants(model)
        currents.prepare()
        if self.law == LINEAR and not currents.linearise(model, self.setpoint):
            return NO_EQUILIBRIUM
        if not currents.tabulate(model):
            return NO_EQUILIBRIUM
        return STEPPED

    def sample(self) -> None:
        """Run the law once."""
        axes = self.axes
        motors = self.motors
        model = self.model
        platform = self.platform
        currents = self.currents
        seen = platform.observe(axes)
        if not (self.started or seen):
            return   # an importer that has not exchanged values yet: this is no measurement
        currents.take_constants(model)
        scale = 1.0
        if self.law == SCHEDULED or self.law == INTERPOLATED:
            scale = currents.look(axes[0].measured)
            # Between samples ξ1 of a law with a table stands for a current, which does not change with the gain.
            self.rescale(scale)
        if not self.started:
            self.hold()
        sample_time = self.sample_time
        observer = self.observer
        for k, axis in enumerate(axes):
            axis.sample(observer, sample_time)
            if exceeds(axis.error, self.trip_tilt if self.tilted[k] else self.trip_error):
                self.tripped = True
        if self.tripped:
            for motor in motors:
                motor.release()
            self.saturated = False
            self.feasible = True   # nothing is demanded any more
            return
        self.feasible = currents.command(axes, motors, model, platform, self.current_limit)
        self.saturated = currents.compare(motors, model, platform, sample_time if self.antiwindup else 0.0)
        oscillator = self.oscillator
        short = currents.short
        for k, axis in enumerate(axes):
            axis.update(oscillator, short[k])
        if scale != 1.0:
            self.rescale(1.0 / scale)

    def hold(self) -> None:
        """Begin such that the mover is held at its place if bumpless, otherwise as if it rested at the setpoint."""
        self.currents.hold(self.axes, self.model, self.platform, self.setpoint, self.bumpless)
        for axis, demand in zip(self.axes, self.currents.demands, strict=True):
            axis.start(demand, axis.measured - axis.reference if self.bumpless else 0.0)
        self.started = True

    def rescale(self, factor: float) -> None:
        """Multiply ξ1 of every axis that a normal force serves."""
        for axis, by_gap in zip(self.axes, self.by_gap, strict=True):
            if by_gap:
                axis.rescale(factor)
