"""What a stage begins with: the numbers of a rig's motors as makers print them, and set-points between its stops."""

from pathlib import Path

from maglev.rig.writer import render
from pmlsm.gap_functions import gap_functions
from pmlsm.rig import Rig

# Set-points of the scenario, as shares of the way from the start to the nearer stop, for every axis in turn; of a tilt
# that of the outermost motor.
SHARES = ((0.0, 0.2, -0.2, 0.1), (0.0, 0.08, -0.08, 0.12), (0.0, -0.08, 0.08, -0.12), (0.0, 0.1, -0.1, 0.05),
          (0.0, -0.1, 0.05, 0.1))


def stage_text(rig: Rig, file: Path) -> str:
    """Text of a description that begins as a rig is; a first motor's numbers are those of all."""
    motor, first, vertical, stage = rig.motor(), rig.horizontal[0], rig.vertical, rig.stage
    f1, f2, f3, f4 = gap_functions(motor, vertical.start)
    gaps = [motor.field.lower + k * (motor.field.upper - motor.field.lower) / 8.0 for k in range(9)]
    return render(
        "new/stage.toml.j2", rig, file=file.name, name=file.stem, suffix=file.stem[:1].upper() + file.stem[1:],
        sharing=f"{rig.sharing:g}", geometry=motor, force=f"{stage.thrust[first.name] * first.mass * f1:.4g}",
        magnets=f"{stage.attraction * vertical.mass * f2:.4g}", direct=f"{stage.coils * vertical.mass * f3:.4g}",
        windings=f"{stage.iron * vertical.mass * f4:.4g}", gaps=[round(gap, 6) for gap in gaps],
        field=[float(f"{motor.field.value(gap):.5g}") for gap in gaps])


def scenario_text(rig: Rig, scenario: Path, own: str | None, more: bool) -> str:
    """Text of a scenario of set-points that lie well between the stops.

    `own` is the description of a stage of the user's; with `more` it has claims, and comments on what else there is.
    """
    setpoints = {}
    for axis, shares in zip(rig.axes, SHARES, strict=False):
        stop, start = axis.stop or rig.gap_stop, rig.vertical.start if axis.rotation else axis.start
        way = min(start - stop.lower, stop.upper - start) / (rig.arm if axis.rotation else 1.0)
        setpoints[axis.name] = [round(1e3 * (axis.start + share * way), 1) for share in shares]
    return render("new/scenario.toml.j2", rig, own=own, name=scenario.stem, scenario=scenario.name, setpoints=setpoints,
                  more=more)


def study_text(rig: Rig, file: Path, scenario: str) -> str:
    """Text of a study of a scenario: mass and friction."""
    return render("new/study.toml.j2", rig, file=file.name, name=file.stem, scenario=scenario)
