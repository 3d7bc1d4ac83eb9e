"""The closed loop of a stage as a scenario has it: what stands in `scenarios/loops` for the rigs of the project."""

from typing import Any

from pmlsm.rig import Rig

PHASES = ("a", "b", "c")


def loop_table(rig: Rig) -> dict[str, Any]:
    """Table of a loop: step, connections, FMUs, axes, motors, and what is measured and compared."""
    axes, motors = rig.axis_names, rig.motor_names
    commands = [f"{motor}.i_{phase}_cmd" for motor in motors for phase in PHASES]
    return {
        "step": rig.sample_time,
        "output_interval": rig.sample_time * max(1, round(1e-3 / rig.sample_time)),
        "stop_flag": "plant.at_stop",
        "trip_flag": "controller.tripped",
        "connections": [*([f"plant.{axis}.encoder", f"controller.{axis}.measured"] for axis in axes),
                        *([f"controller.{command}", f"plant.{command}"] for command in commands)],
        "fmus": {"controller": {"model": f"Regulator{rig.suffix}"}, "plant": {"model": f"Plant{rig.suffix}"}},
        "axes": {axis: {"position": f"plant.{axis}.position", "reference": f"controller.{axis}.reference",
                        "vertical": axis == rig.vertical.name} for axis in axes},
        "motors": {motor: {"currents": [f"plant.{motor}.i_{phase}" for phase in PHASES],
                           "commands": [f"controller.{motor}.i_{each}_cmd" for each in ("d", "q", *PHASES)]}
                   for motor in motors},
        "metrics": {"bands": [1e-4, max(rig.resolution, 1e-6)], "fail_error": 1e-3},
        "check": {"interval": 0.1, "signals": {f"plant.{axis}.position": {"absolute": 1e-4} for axis in axes}}}
