"""The closed loop of a user's stage as a scenario has it; `scenarios/loops` has those of the project's stages."""

from itertools import pairwise
from typing import Any

from maglev.user.gain_design import feasible_steps
from pmlsm.stage_description import StageDescription

PHASES = ("a", "b", "c")

# Setpoints as shares of a step, for every axis in turn. A step is a fifth of the way from the start to the nearer stop,
# for a tilt to that of the outermost motor. It is no larger than the remaining forces can follow.
SHARES = ((0.0, 1.0, -1.0, 0.5), (0.0, 0.4, -0.4, 0.6), (0.0, -0.4, 0.4, -0.6), (0.0, 0.5, -0.5, 0.25),
          (0.0, -0.5, 0.25, 0.5))
TIMES = (0, 1, 6, 11)   # s
LARGEST = 0.2           # step, of the way


def setpoints(stage: StageDescription) -> dict[str, list[float]]:
    """Setpoints of every axis (mm, mrad), at the times of `TIMES`: within the travel and the forces of the stage."""
    gaps, largest = {}, feasible_steps(stage)
    for axis, shares in zip(stage.axes, SHARES, strict=False):
        stop, start = axis.stop or stage.gap_stop, stage.vertical.start if axis.rotation else axis.start
        way = min(start - stop.lower, stop.upper - start) / (stage.arm if axis.rotation else 1.0)
        step = min(LARGEST * way, largest[axis.name])
        gaps[axis.name] = [float(f"{1e3 * (axis.start + float(f'{share * step:.1g}')):.6g}") for share in shares]
    return gaps


def settling_band(stage: StageDescription) -> float:
    """Widest band to settle in (m): 0.1 mm, or of a stage with small setpoints less than a third of each step."""
    moves = [1e-3 * abs(after - before) for axis, values in setpoints(stage).items() if not stage.axis(axis).rotation
             for before, after in pairwise(values) if after != before]
    room = min(moves) / 3.0
    return next((band for band in (1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6) if band <= room), 1e-6)


def setpoint_signals(stage: StageDescription) -> list[dict[str, Any]]:
    """Signals of a scenario that has `signals = "setpoints"`."""
    return [{"to": f"controller.{axis}.reference", "kind": "steps", "unit": f"m{stage.axis(axis).unit('m')}",
             "times": [*TIMES], "values": values}
            for axis, values in setpoints(stage).items()]


def loop_table(stage: StageDescription) -> dict[str, Any]:
    """Table of a loop: step, connections, FMUs, axes, motors, measurements and comparisons."""
    motors, finest = stage.motor_names, max(stage.resolution, 1e-6)
    bands = [*dict.fromkeys((max(settling_band(stage), finest), finest))]
    # Tilts that move the outermost motor as much.
    arm = stage.arm or 1.0
    tilts: dict[str, Any] = {"tilt_bands": [band / arm for band in bands], "fail_tilt": 1e-3 / arm}
    commands = [f"{current}_cmd" for current in stage.phase_names]
    return {
        "step": stage.sample_time,
        "output_interval": stage.sample_time * max(1, round(1e-3 / stage.sample_time)),
        "stop_flag": "plant.at_stop",
        "trip_flag": "controller.tripped",
        "connections": [*([f"plant.{encoder}", f"controller.{encoder.replace('encoder', 'measured')}"]
                          for encoder in stage.encoders),
                        *([f"controller.{command}", f"plant.{command}"] for command in commands)],
        "fmus": {"controller": {"model": f"Regulator{stage.suffix}"}, "plant": {"model": f"Plant{stage.suffix}"}},
        "axes": {axis: {"position": f"plant.{axis}.position", "reference": f"controller.{axis}.reference",
                        "vertical": axis == stage.vertical.name, "rotation": of.rotation}
                 for of in stage.axes for axis in [of.name]},
        "motors": {motor: {"currents": [f"plant.{motor}.i_{phase}" for phase in PHASES],
                           "commands": [f"controller.{motor}.i_{current}_cmd" for current in ("d", "q", *PHASES)]}
                   for motor in motors},
        "metrics": {"bands": bands, "fail_error": 1e-3, **(tilts if stage.rotations else {})},
        "check": {"interval": 0.1, "signals": {f"plant.{axis.name}.position": {
            "absolute": 1e-4 / (arm if axis.rotation else 1.0)} for axis in stage.axes}}}
