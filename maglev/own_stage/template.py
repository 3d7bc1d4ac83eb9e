"""Text of a description to begin with: the stage of a rig, with the numbers of its motors as makers print them."""

from pathlib import Path

from pmlsm.gap_functions import gap_functions
from pmlsm.rig import Rig, RigAxis, RigMotor

TEXT = '''# A stage of yours: plant, controllers, estimator and closed loops follow from this file.
#
#     maglev build --rig {file}                   # FMUs Plant{suffix}, Regulator{suffix}, PID{suffix} …; --native: in C
#     maglev run {scenario} --plot      # its first flight
#
# Numbers are SI, or text with a unit. In brackets: the range, where it is not plain. docs/own_stage.md has the rest.

name = "{name}"               # small letters and digits: the FMUs are named after it
title = "stage {name}"
sample_time = {sample_time!r}        # s, of the controllers [1e-6…1]
sharing = {sharing:g}                 # motors that share each current below; 1 where each has amplifiers of its own
resolution = {resolution!r}          # m, of the encoders; 0 = exact
modulation = {modulation!r}         # of the attraction along the slots [0…1]: 1 − modulation sin²(π x/slot pitch)
{height}
# Axes by the names that the ports get: first the air gap (larger is lower), then one or two horizontal axes{tilts}.
{axes}
# Motors, or groups of {sharing:g} with one current, and the horizontal axis that each drives; all of them carry the mover.
{motors}{motor_stop}
# Of the motor's drawing: pitches, slots, magnets.
[geometry]
pole_pitch = {pole_pitch!r}        # m [1e-3…1]; makers also print the magnetic period, which is two of them
slot_pitch = {slot_pitch!r}        # m [1e-4…1]; a third of the pole pitch where there is one slot for each phase and pole
slot_width = {slot_width!r}         # m, less than the slot pitch; the opening towards the gap
magnet_height = {magnet_height!r}        # m [1e-5…0.1]
recoil_permeability = {recoil_permeability!r}   # of the magnets, relative: 1.05 for NdFeB

# Of the motor's data sheet, for one motor. In place of [catalogue] a table [stage] can have the constants themselves.
[catalogue]
currents = "peak"           # or "rms", as the data sheet means its amperes; a maker's N/A is mostly N/A rms
force_constant = {force:.4g}       # N/A, thrust per current ("force constant", "Kf"), at the gap of the next line
at = {start!r}                  # m
attraction = {attraction:.4g}          # N, with no current ("attraction force", "magnetic attraction"), at the gap of the next line
attraction_gap = {start!r}      # m
peak = {peak!r}                  # A ("peak current", "maximum current")
continuous = {continuous!r}            # A ("continuous current"); 0 = no limit
# No data sheet has the next two. Without them they follow from those above, or from the formulas of [catalogue.winding],
# which are off by factors: docs/own_stage.md says by which.
direct_constant = {direct:.4g}      # N/A, normal force per direct current, at the gap `at`; measured
iron_attraction = {iron:.4g}     # N/A², attraction of the iron by the current alone; measured
# [catalogue.winding]       # thesis (2.2), (2.4); also in place of force_constant or attraction, where one is missing
# turns = 900
# pole_pairs = 3
# magnets = 4
# magnet_width = "28.58 mm"
# length = "50 mm"
# coercivity = "875.4 kA/m"
# factor = 1.0              # winding factor

# Field of the magnets at the stator, from `lower` to `upper`, within which all gaps have to lie. As a table; or
# B0 = "0.4 T" with decay = "13 mm"; or coefficients = […] of a polynomial in s, −1 at `lower` and 1 at `upper`.
[field]
lower = {lower!r}
upper = {upper!r}
gaps = {gaps}
B = {field}

[design]
current_limit = {limit!r}         # A, of i_d and i_q of the regulators; 0 = none
pid_current_limit = {limit!r}
antiwindup = false
'''

AXIS = '''
[axes.{name}]
meaning = "{meaning}"
mass = {mass!r}                  # kg, all that moves along {name} [1e-3…1e6]
start = {start!r}               # m, where it begins{nominal}
bias = {bias!r}                  # m/s², constant, such as by misalignment
friction = {{ coulomb = {coulomb!r}, presliding = {presliding!r}, viscous = {viscous!r} }}   # N, m, N s/m; of the guides
ripple = {{ amplitude = {amplitude!r}, period = {period!r} }}   # m/s², m
'''

STOP = "stop = {{ lower = {lower!r}, upper = {upper!r} }}   # m\n"

TILT = '''
[axes.{name}]
rotation = true             # a tilt of the platform: rad, N m
meaning = "{meaning}"
mass = {mass!r}                  # kg m², the inertia [1e-3…1e6]
start = {start!r}               # rad, where it begins
bias = {bias!r}                  # rad/s², constant
friction = {{ coulomb = {coulomb!r}, presliding = {presliding!r}, viscous = {viscous!r} }}   # N m, rad, N m s; of the guides
'''

AXIS_DESIGN = '''
[axes.{name}.design]
# poles = {poles}   # rad/s, five; without them those of the 3-DOF stage, scaled {scale}
antiwindup_gain = 0.0
'''

MOTOR = '''
[motors.{name}]
drives = "{drives}"
'''

PLACE = '''x = {x!r}                    # m, place on the platform along {along[0]} and {along[1]}, from the centre of mass [-10…10]
z = {z!r}
'''

HEIGHT = "height = {height!r}             # m, of the magnets' faces against the centre of mass, downwards [-1…1]\n"

MOTOR_STOP = '''
# Stops at the motors, on the air gap of each.
[motor_stop]
lower = {lower!r}              # m
upper = {upper!r}
stiffness = {stiffness!r}        # N/m [0…1e8]
damping = {damping!r}             # N s/m [0…1e6]
'''


def stage_text(rig: Rig, file: Path) -> str:
    """Text of a description that begins as a rig is; a first motor's numbers are those of all."""
    motor, first, vertical = rig.motor(), rig.horizontal[0], rig.vertical
    f1, f2, f3, f4 = gap_functions(motor, vertical.start)
    gaps = [motor.field.lower + k * (motor.field.upper - motor.field.lower) / 8.0 for k in range(9)]
    amplifier = rig.motors[0].amplifier
    return TEXT.format(
        file=file.name, scenario=f"{file.stem}-setpoints.toml", name=file.stem,
        suffix=file.stem[:1].upper() + file.stem[1:], sample_time=rig.sample_time, sharing=rig.sharing,
        resolution=rig.resolution, modulation=rig.modulation, axes="".join(axis_text(rig, axis) for axis in rig.axes),
        motors="".join(motor_text(rig, each) for each in rig.motors),
        tilts=", then the tilts about these" if rig.rotations else "",
        height=HEIGHT.format(height=rig.height) if rig.rotations else "",
        motor_stop="" if rig.motor_stop is None else MOTOR_STOP.format(**vars(rig.motor_stop)),
        **{name: value for name, value in vars(motor).items() if isinstance(value, float)},
        force=rig.stage.thrust[first.name] * first.mass * f1, start=vertical.start,
        attraction=rig.stage.attraction * vertical.mass * f2, direct=rig.stage.coils * vertical.mass * f3,
        iron=rig.stage.iron * vertical.mass * f4, peak=amplifier.peak, continuous=amplifier.continuous,
        lower=motor.field.lower, upper=motor.field.upper, gaps=[round(gap, 6) for gap in gaps],
        field=[float(f"{motor.field.value(gap):.5g}") for gap in gaps], limit=rig.design.current_limit)


def axis_text(rig: Rig, axis: RigAxis) -> str:
    """Text of an axis."""
    driven = axis in rig.horizontal
    text = TILT if axis.rotation else AXIS + (STOP if axis.stop else "")
    return (text + AXIS_DESIGN).format(
        **{name: getattr(axis, name) for name in ("name", "meaning", "mass", "start", "bias")},
        **vars(axis.friction), **vars(axis.ripple), **vars(axis.stop or rig.gap_stop),
        nominal=": the nominal gap, at which the linear laws are designed" if axis == rig.vertical else "",
        poles="[-5, -6, -7, -8, -9]" if driven else "[-90, [-4, 6], [-2, 2]]",
        scale="by what the motors can accelerate" if driven else "by the rate at which the mover "
        f"{'tilts' if axis.rotation else 'falls'}")


def motor_text(rig: Rig, motor: RigMotor) -> str:
    """Text of a motor."""
    text = MOTOR + (PLACE if rig.rotations else "")
    return text.format(name=motor.name, drives=motor.drives, x=motor.x, z=motor.z,
                       along=[axis.name for axis in (*rig.horizontal, *rig.horizontal)])
