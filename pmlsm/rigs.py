"""The two rigs: their axes, motors and constants, for all who name them. It describes the blocks; no block reads it."""

from dataclasses import dataclass

from pmlsm.data_sheet import (
    MASS_H,
    MASS_V,
    MASS_X,
    MASS_Y,
    MASS_Z,
    MOTORS_3DOF,
    MOTORS_IN_PAIR,
    SAMPLE_TIME_2DOF,
    SAMPLE_TIME_3DOF,
)

# Units of the constants.
THRUST = "m/(s2.A)"
ATTRACTION = "m/(s2.T2)"
COILS = "m/(s2.A.T)"
IRON = "m/(s2.A2)"


@dataclass(frozen=True)
class RigAxis:
    """Axis of motion.

    Attributes
    ----------
    name : str
    meaning : str
        What its position is.
    mass : float
        Nominal mass that moves along it, kg; the constants are accelerations at it.
    """

    name: str
    meaning: str
    mass: float


@dataclass(frozen=True)
class RigMotor:
    """Motor, or pair with one current, and the horizontal axis that it drives; all carry the vertical axis."""

    name: str
    drives: str


@dataclass(frozen=True)
class RigConstant:
    """Constant of the equations of motion: its name, the axis in whose row it stands, its unit, and its meaning."""

    name: str
    axis: str
    unit: str
    meaning: str


@dataclass(frozen=True)
class Rig:
    """A rig.

    Attributes
    ----------
    name : str
        As in the names of experiments.
    vertical : RigAxis
        The air gap.
    horizontal : tuple of RigAxis
    motors : tuple of RigMotor
        In the order of the horizontal axes.
    constants : tuple of RigConstant
        C1 first; those of the vertical axis are attraction, coils, iron.
    carrying, driving : float
        Motors that carry the mover, and those that share one current.
    sample_time : float
        Of its controllers, s.
    sample_time_source, stage_source, model_source : str
        Where the thesis states the sample time, the constants that the stage has, and those that the controllers have.
    """

    name: str
    vertical: RigAxis
    horizontal: tuple[RigAxis, ...]
    motors: tuple[RigMotor, ...]
    constants: tuple[RigConstant, ...]
    carrying: float
    driving: float
    sample_time: float
    sample_time_source: str
    stage_source: str
    model_source: str

    @property
    def axes(self) -> tuple[RigAxis, ...]:
        """All axes, the vertical one first."""
        return (self.vertical, *self.horizontal)

    @property
    def axis_names(self) -> tuple[str, ...]:
        """Names of all axes, the vertical one first."""
        return tuple(axis.name for axis in self.axes)

    @property
    def motor_names(self) -> tuple[str, ...]:
        """Names of the motors."""
        return tuple(motor.name for motor in self.motors)

    def constants_of(self, axis: str) -> tuple[str, ...]:
        """Names of the constants in the row of an axis."""
        return tuple(constant.name for constant in self.constants if constant.axis == axis)


RIG_2DOF = Rig(
    name="2dof",
    vertical=RigAxis("v", "air gap", MASS_V),
    horizontal=(RigAxis("h", "horizontal displacement", MASS_H),),
    motors=(RigMotor("motor", "h"),),
    constants=(
        RigConstant("C1", "h", THRUST, "thrust (4.3)"),
        RigConstant("C2", "v", ATTRACTION, "attraction between magnets and iron (4.3)"),
        RigConstant("C3", "v", COILS, "normal force between magnets and coils (4.3)"),
        RigConstant("C4", "v", IRON, "normal force between coils and iron (4.3)")),
    carrying=1.0,
    driving=1.0,
    sample_time=SAMPLE_TIME_2DOF,
    sample_time_source="stated, section 4.1.4",
    stage_source="stated, Table 4.2",
    model_source="stated, Table 4.3")

RIG_3DOF = Rig(
    name="3dof",
    vertical=RigAxis("y", "air gap", MASS_Y),
    horizontal=(RigAxis("x", "horizontal displacement along x", MASS_X),
                RigAxis("z", "horizontal displacement along z", MASS_Z)),
    motors=(RigMotor("alpha", "x"), RigMotor("beta", "z")),
    constants=(
        RigConstant("C1", "x", THRUST, "thrust along x (5.3)"),
        RigConstant("C2", "z", THRUST, "thrust along z (5.3)"),
        RigConstant("C3", "y", ATTRACTION, "attraction between magnets and iron (5.3)"),
        RigConstant("C4", "y", COILS, "normal force between magnets and coils (5.3)"),
        RigConstant("C5", "y", IRON, "normal force between coils and iron (5.3)")),
    carrying=MOTORS_3DOF,
    driving=MOTORS_IN_PAIR,
    sample_time=SAMPLE_TIME_3DOF,
    sample_time_source="stated, section 5.1.4",
    stage_source="stated, Table 5.2",
    model_source="stated, Table 5.3")

RIGS = {rig.name: rig for rig in (RIG_2DOF, RIG_3DOF)}
