"""A motor by its data sheet, as `--motor` takes it, and a copy of a stage with such motors instead of its own."""

from collections.abc import Sequence
from dataclasses import MISSING, asdict, dataclass, fields, replace
from math import pi
from pathlib import Path

from maglev.descriptions.data_sheet import Catalogue, Field, field_geometry, optional
from maglev.descriptions.description_file import PACKAGED, Reader
from maglev.descriptions.packaged import PACKAGED_STAGES, SINGLE
from maglev.files.errors import StageError, nearest, one_of
from maglev.files.toml_file import read_toml
from maglev.files.units import number_or_text
from pmlsm.gap_functions import gap_functions
from pmlsm.stage_description import StageDescription, quantity
from pmlsm.velocity_rows import GRAVITY

MOTORS = {path.stem: path for path in (PACKAGED / "motors" / f"{size}.toml" for size in ("small", "medium", "large"))}

SIDE_BY_SIDE = "side-by-side"   # stage to begin with: two motors side by side under one axis, which also tilt it
APART = 0.3                  # m, between these two

TRAVEL = 0.3        # of the gap, to either stop
GAP = 0.4           # of a pole pitch: the gap where none is given
SURFACE_FIELD = 0.6   # T, at the magnets; forces are known at a gap, so that only its decay counts
RESOLUTION = 1e-6   # m, of the encoders next to a motor of such a gap


def two_motors() -> StageDescription:
    """The 2-DOF stage on two of its motors, twice as heavy, with a platform that tilts about the horizontal axis."""
    description, roll = PACKAGED_STAGES[SINGLE], next(description.rotations[0]
                                                      for description in PACKAGED_STAGES.values()
                                                      if description.rotations)
    travelling = description.horizontal[0]
    motor, mass = description.motors[0], 2.0 * description.vertical.mass
    inertia = float(f"{mass * (0.5 * APART) ** 2:.3g}")   # as of masses at the motors
    plant, model = (replace(of, thrust={name: value / 2.0 for name, value in of.thrust.items()},
                            attraction=of.attraction / 2.0, coils=of.coils / 2.0, iron=of.iron / 2.0)
                    for of in (description.plant, description.model))
    return replace(
        description, title="2-DOF stage on two motors", motor_stop=description.gap_stop, experiment="", equation="",
        plant=plant,
        model=model,
        axes=(replace(description.vertical, mass=mass, stop=None), replace(travelling, mass=2.0 * travelling.mass),
              replace(roll, meaning=f"tilt about {travelling.name}", mass=inertia)),
        motors=(replace(motor, name="left", z=-0.5 * APART), replace(motor, name="right", z=0.5 * APART)))


@dataclass(frozen=True)
class Motor:
    """Numbers of one motor as makers print them, and of a stage with it: nominal gap and mass."""

    force_constant: float = quantity("N/A", 1e-3, 1e5)       # thrust per current
    attraction: float = quantity("N", 1e-2, 1e6)             # without current
    attraction_gap: float = quantity("m", 2e-4, 0.05)        # air gap of it
    pole_pitch: float = quantity("m", 1e-3, 1.0)             # half of the magnetic period
    peak: float = quantity("A", 1e-3, 700.0)
    currents: str = "rms"                                    # or "peak": how amperes are meant
    at: float | None = optional("m", 2e-4, 0.05)             # air gap of the force constant, that of the attraction
    continuous: float | None = optional("A", 0.0, 700.0)
    lag: float | None = optional("s", 0.0, 0.1)              # of its amplifiers
    resistance: float = quantity("Ohm", 1e-3, 1e4, 5.0)      # of a phase
    inductance: float = quantity("H", 1e-6, 10.0, 0.03)
    slot_pitch: float | None = optional("m", 1e-4, 1.0)      # a third of the pole pitch
    slot_width: float | None = optional("m", 1e-5, 1.0)      # half of the slot pitch
    magnet_height: float | None = optional("m", 1e-5, 0.1)   # a quarter of the pole pitch
    gap: float | None = optional("m", 2e-4, 0.05)            # nominal, of the stage
    mass: float | None = optional("kg", 1e-3, 1e6)           # of the mover; by default carried without current


def read_motor(given: Sequence[str]) -> Motor:
    """Return a motor by texts: the name of a packaged one, or KEY=VALUE, which replace its numbers.

    StageError with name, value and expected value.
    """
    table: dict[str, object] = {}
    known = [field.name for field in fields(Motor)]
    for text in given:
        key, equals, value = text.partition("=")
        if not equals:
            if text not in MOTORS:
                raise StageError(f"--motor {text}: expected {one_of(text, MOTORS)}, or KEY=VALUE with one of "
                               f"{', '.join(known)}")
            table = {**read_toml(MOTORS[text]), **table}
        elif key not in known:
            raise StageError(f"--motor {text}: no such key; {nearest(key, known)}")
        else:
            table[key] = value if key == "currents" else number_or_text(value)
    lacking = [field.name for field in fields(Motor) if field.default is MISSING and field.name not in table]
    if lacking:
        raise StageError(f"--motor: {', '.join(lacking)} missing, expected KEY=VALUE for each, or first one of "
                       f"{', '.join(MOTORS)}")
    motor: Motor = Reader(Path("--motor")).read(Motor, table, "")
    if motor.currents not in ("rms", "peak"):
        raise StageError(f"--motor currents={motor.currents}: expected rms or peak")
    return motor


def sheet_of(motor: Motor) -> Catalogue:
    """The motor's data sheet as a description has it."""
    return Catalogue(motor.currents, motor.force_constant, motor.at or motor.attraction_gap, motor.attraction,
                     motor.attraction_gap, peak=motor.peak, continuous=motor.continuous or 0.0, lag=motor.lag,
                     resistance=motor.resistance, inductance=motor.inductance)


def field_of(motor: Motor, gap: float) -> Field:
    """Field of a motor that is used about a gap (m)."""
    gaps = [gap, motor.attraction_gap, motor.at or motor.attraction_gap]
    return Field(float(f"{0.6 * min(gaps):.2g}"), float(f"{1.6 * max(gaps):.2g}"), B0=SURFACE_FIELD,
                 decay=float(f"{motor.pole_pitch / pi:.4g}"))


def drawing_geometry(motor: Motor) -> dict[str, float]:
    """Drawing of a motor."""
    slot_pitch = motor.slot_pitch or motor.pole_pitch / 3.0
    return {"pole_pitch": motor.pole_pitch, "slot_pitch": float(f"{slot_pitch:.6g}"),
            "slot_width": motor.slot_width or float(f"{0.5 * slot_pitch:.6g}"),
            "magnet_height": motor.magnet_height or float(f"{0.25 * motor.pole_pitch:.6g}")}


def packaged_tables(name: str, gap: float) -> dict[str, dict[str, object]]:
    """Tables [geometry], [catalogue] and [field] of a packaged motor that is used about a gap (m)."""
    motor = read_motor([name])
    sheet, field = ({key: value for key, value in asdict(of).items() if value not in (None, ())}
                    for of in (sheet_of(motor), field_of(motor, gap)))
    return {"geometry": dict(drawing_geometry(motor)), "catalogue": sheet, "field": field}


def with_motor(stage: StageDescription, motor: Motor) -> tuple[StageDescription, Field]:
    """A stage with other motors in its places: their geometry and field, and gap, mass and stops that go with them.

    StageError where the slots are no slots, or the field cannot be met.
    """
    gap = motor.gap or float(f"{GAP * motor.pole_pitch:.2g}")
    if gap > motor.pole_pitch:
        raise StageError(f"--motor gap={1e3 * gap:g}mm: expected at most pole_pitch = {1e3 * motor.pole_pitch:g} mm: "
                       "beyond it the field is almost zero")
    field, geometry = field_of(motor, gap), drawing_geometry(motor)
    if not geometry["slot_width"] < geometry["slot_pitch"]:
        raise StageError(f"--motor slot_width={geometry['slot_width']:g}: expected less than slot_pitch = "
                       f"{geometry['slot_pitch']:g} m")
    stage = replace(stage, geometry={**geometry, **field_geometry("--motor", field)}, resolution=RESOLUTION)
    attracted = stage.carrying * motor.attraction * (gap_functions(stage.motor(), gap)[1]
                                                   / gap_functions(stage.motor(), motor.attraction_gap)[1])
    mass = motor.mass or float(f"{attracted / GRAVITY:.3g}")
    stop = replace(stage.gap_stop, lower=float(f"{(1.0 - TRAVEL) * gap:.3g}"),
                   upper=float(f"{(1.0 + TRAVEL) * gap:.3g}"))
    return replace(stage, axes=tuple(replace(
        axis, mass=mass if not axis.rotation else float(f"{axis.mass * mass / stage.vertical.mass:.3g}"),
        start=gap if axis is stage.vertical else axis.start,
        stop=stop if axis is stage.vertical and axis.stop is not None else axis.stop,
        ripple=replace(axis.ripple, amplitude=0.0, period=geometry["slot_pitch"]),
        friction=replace(axis.friction,
                         presliding=float(f"{axis.friction.presliding * gap / stage.vertical.start:.2g}"))
        if axis not in stage.horizontal else axis.friction) for axis in stage.axes),
        motor_stop=stop if stage.motor_stop is not None else None), field
