"""What cannot be linearised is refused in one line that says what to do, from Python and from the command line."""

from typing import Any

import pytest
from command_line import error_line, maglev

from maglev.files.errors import LinearModelError
from maglev.linear.equilibrium import equilibrium
from maglev.linear.linearise import linearise

WIDE = {"y.stop.stiffness": 0.0, "y.stop.damping": 0.0}


@pytest.mark.parametrize(("name", "at", "options", "message"), [
    ("Plant4DOF", {"y": 0.025}, {}, "'Plant4DOF' cannot be linearised, expected one of Plant2DOF, Plant3DOF, "),
    ("Plant3DOF", {"w": 0.025}, {}, "Plant3DOF at w = 0.025: no axis 'w', expected one of y, x, z"),
    ("Plant3DOF", {"x": 0.0}, {}, "Plant3DOF: no y, expected the air gap to linearise at, such as y = 25 mm"),
    ("Plant3DOF", {"y": "25 A"}, {}, "Plant3DOF at y: '25 A' is in A, expected a quantity in m"),
    ("Plant3DOF", {"y": "25"}, {}, "Plant3DOF at y: '25' has no unit, expected a number without quotes or a unit such"),
    ("Plant3DOF", {"y": float("nan")}, {}, "Plant3DOF at y: nan is not a quantity, expected a finite number"),
    ("Plant3DOF", {"y": 25.0}, {}, "Plant3DOF at y = 25 m: expected an air gap of 0.008…0.04 m, where the motor's fie"),
    ("Plant3DOF", {"y": "7.9 mm"}, {}, "Plant3DOF at y = 0.0079 m: expected an air gap of 0.008…0.04 m"),
    ("Plant3DOF", {"y": "35 mm"}, {}, "Plant3DOF at y = 35 mm: beyond the end stops, expected y within 18.5…32 mm"),
    ("Plant3DOF", {"y": "25 mm", "x": 0.07}, {}, "Plant3DOF at x = 70 mm: beyond the end stops, expected x within -62"),
    ("Plant3DOF", {"y": "31 mm"}, {}, "Plant3DOF at y = 31 mm: alpha needs i_d = -4.65 A, i_q = 0.159 A, expected at "
     "most alpha.amplifier.continuous = 4 A: choose a smaller gap, or a larger rating to see beyond it"),
    ("Plant3DOF", {"y": "12 mm"}, {"parameters": WIDE}, "expected at most alpha.amplifier.continuous = 4 A: choose a "
     "larger gap"),
    ("Plant3DOF", {"y": "34 mm"}, {"parameters": {**WIDE, "alpha.amplifier.continuous": 0.0}},
     "expected at most alpha.amplifier.peak = 5 A: choose a smaller gap"),
    ("Plant3DOF", {"y": "25 mm"}, {"parameters": {"bus_voltage": "4 V"}},
     "alpha needs 4.19 V for i_d = -1.19 A, i_q = 0.115 A, expected at most bus_voltage = 4 V"),
    ("Plant3DOF", {"y": "25 mm"}, {"parameters": {"beta.phase_c.open": True}},
     "beta.phase_c.open = true, expected false: a linear model has no faults"),
    ("Plant3DOF", {"y": "20 mm"}, {"parameters": {"C3": 9e4}},
     "Plant3DOF at y = 20 mm: no direct current holds the mover: the coils push it off by at most 191 m/s²"),
    ("Plant3DOF", {"y": "20 mm"}, {"parameters": {"C4": 0.0, "C5": 0.0}}, "push it off by at most 0 m/s²"),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"C1": 0.0}},
     "Plant2DOF at v = 20 mm: no current holds h against 0.1 m/s², expected a thrust constant above 0"),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"C1": 5e-324}}, "no current holds h against 0.1 m/s², expec"),
    ("Plant2DOF", {"v": "20 mm"}, {"hold": 1e300}, "Plant2DOF, held for 1e+300 s: its linear model overflows"),
    ("Plant2DOF", {"v": "20 mm"}, {"hold": 1000.0}, "Plant2DOF, held for 1000 s: its linear model overflows"),
    ("Plant3DOF", {"y": "20 mm"}, {"parameters": {"alpha.amplifier.lag": 5e-324}}, "Plant3DOF: its linear model o"),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"v.locked": True}},
     "Plant2DOF: v.locked = true, expected an axis that is free to move"),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"v.mas": 4.0}},
     "Plant2DOF has no parameter 'v.mas'; nearest is 'v.mass'"),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"v.mass": "4 N"}},
     "Plant2DOF: v.mass: '4 N' is in N, expected a quantity in kg"),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"v.mass": -1.0}},
     "Plant2DOF: v.mass = -1 kg, expected a number from 0.001 to 1e+06 kg"),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"C2": "4 N"}},
     "Plant2DOF: C2: '4 N' is in N, expected a quantity in m/(s2.T2)"),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"v.locked": 1.0}}, "v.locked = 1.0, expected true or false"),
    ("Plant2DOF", {"v": "20 mm"}, {"hold": 0.0}, "Plant2DOF: sample time = 0.0 s, expected a positive, finite one"),
    ("Plant2DOF", {"v": "20 mm"}, {"hold": "1 mm"}, "Plant2DOF: hold: '1 mm' is in mm, expected a quantity in s"),
    ("Plant2DOF", {"v": "20 mm"}, {"currents": "dk"}, "currents = 'dk', expected one of dq, phases"),
    ("PID2DOF", {"v": "20 mm"}, {"hold": 1e-3}, "PID2DOF: hold = 0.001: not possible, it is sampled at its"),
    ("Regulator3DOF", {"y": "31 mm"}, {}, "alpha.i_d_cmd = -4.53 A is beyond current_limit = 4 A, where the controller "
     "is not linear, expected a smaller gap or another limit (0 = none)"),
    ("LinearRegulator3DOF", {"y": "25 mm"}, {"parameters": {"setpoint": "9 mm", "C3": 2700.0, "current_limit": 0.0}},
     "LinearRegulator3DOF: setpoint = 0.009 m, expected an air gap at which the model with these constants has an"),
    ("PID2DOF", {"v": "20 mm"}, {"parameters": {"v.prefilter": 9000.0}}, "PID2DOF: v.prefilter = 9000.0 rad/s, h.pref"),
    ("Regulator2DOF", equilibrium("Plant3DOF", {"y": "25 mm"}), {},
     "expected an equilibrium of its own stage, with motor"),
])
def test_one_line(name: str, at: Any, options: dict[str, Any], message: str) -> None:
    with pytest.raises(LinearModelError) as caught:
        linearise(name, at, **options)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("arguments", "message"), [
    (["Plant3DOF", "--at", "y=35mm"], "maglev: Plant3DOF at y = 35 mm: beyond the end stops, expected y within 18.5…3"),
    (["Plant3DOF", "--at", "y"], "--at y: expected a name, = and a value with its unit, such as y=25mm"),
    (["Plant3DOF", "--at", "y=25mm", "--set", "y.mass=7kg"],
     "set: y.mass = 7kg: expected plant.… or controller.… or measurement.…, such as plant.y.mass=7.2kg"),
    (["Plant3DOF", "--at", "y=25mm", "--set", "controller.C3=1"],
     "--set controller.C3: expected plant.… with Plant3DOF"),
    (["Plant3DOF", "--at", "y=25mm", "--plot"],
     "--open, --measure and --plot are for loops, expected a plant and a controller"),
    (["Plant3DOF", "PID3DOF", "--at", "y=25mm", "--forces"], "--forces: needs one model"),
    (["Plant3DOF", "PID3DOF", "Plant3DOF", "--at", "y=25mm"], "'PID3DOF' is no measurement, expected one of"),
    (["PID3DOF", "Plant3DOF", "--at", "y=25mm"], "'PID3DOF' is no plant, expected one of Plant2DOF, Plant3DOF"),
    (["PlantMine", "--at", "y=25mm"], "Measurement5DOF, or one of your own stage, with stage = mine.toml; nea"),
    (["PlantMine", "PID3DOF", "--at", "y=25mm"],
     "'PlantMine' is no plant, expected one of Plant2DOF, Plant3DOF, Plant5DOF, or one of your own stage"),
    (["Plant3DOF", "PIDMine", "--at", "y=25mm"], "or one of your own stage, with stage = mine.toml"),
    (["Plant3DOF", "PID4DOF", "--at", "y=25mm"], "'PID4DOF' is no controller with a linear model, expected one of"),
    (["Plant3DOF", "PID2DOF", "--at", "y=25mm"], "expected an equilibrium of its own stage, with motor"),
    (["Plant3DOF", "PID3DOF", "--at", "y=25mm", "--open", "v"], "no signal 'v' to open the loop at, expected one of"),
])
def test_one_line_at_the_command_line(arguments: list[str], message: str) -> None:
    assert message in error_line(maglev("linearise", *arguments))
