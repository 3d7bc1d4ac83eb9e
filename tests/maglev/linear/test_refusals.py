"""What cannot be linearised is refused in one line that says what to do, from Python and from the command line."""

from typing import Any

import pytest
from command_line import error_line, maglev
from facts import raises, require_facts

from maglev.files.errors import LinearModelError
from maglev.linear.equilibrium import equilibrium
from maglev.linear.linearise import linearise

WIDE = {"y.stop.stiffness": 0.0, "y.stop.damping": 0.0}


@pytest.mark.parametrize(("name", "at", "options", "facts"), [
    ("Plant4DOF", {"y": 0.025}, {}, ["'Plant4DOF'", "Plant2DOF", "Plant3DOF"]),
    ("Plant3DOF", {"w": 0.025}, {}, ["Plant3DOF", "'w'", "0.025", "y, x, z"]),
    ("Plant3DOF", {"x": 0.0}, {}, ["Plant3DOF", "y", "25 mm"]),
    ("Plant3DOF", {"y": "25 A"}, {}, ["Plant3DOF", "y", "'25 A'", "m"]),
    ("Plant3DOF", {"y": "25"}, {}, ["Plant3DOF", "y", "'25'", "unit"]),
    ("Plant3DOF", {"y": float("nan")}, {}, ["Plant3DOF", "y", "nan"]),
    ("Plant3DOF", {"y": 25.0}, {}, ["Plant3DOF", "y", "25 m", "0.008…0.04 m"]),
    ("Plant3DOF", {"y": "7.9 mm"}, {}, ["Plant3DOF", "y", "0.0079 m", "0.008…0.04 m"]),
    ("Plant3DOF", {"y": "25 mm", "x": 0.07}, {}, ["Plant3DOF", "x", "70 mm", "-62…62 mm"]),
    ("Plant3DOF", {"y": "31 mm"}, {},
     ["Plant3DOF", "y", "31 mm", "alpha", "-4.65 A", "0.159 A", "alpha.amplifier.continuous", "4 A", "smaller gap"]),
    ("Plant3DOF", {"y": "12 mm"}, {"parameters": WIDE}, ["alpha.amplifier.continuous", "4 A", "larger gap"]),
    ("Plant3DOF", {"y": "34 mm"}, {"parameters": {**WIDE, "alpha.amplifier.continuous": 0.0}},
     ["alpha.amplifier.peak", "5 A", "smaller gap"]),
    ("Plant3DOF", {"y": "25 mm"}, {"parameters": {"bus_voltage": "4 V"}},
     ["alpha", "4.19 V", "-1.19 A", "0.115 A", "bus_voltage", "4 V"]),
    ("Plant3DOF", {"y": "25 mm"}, {"parameters": {"beta.phase_c.open": True}}, ["beta.phase_c.open", "true", "false"]),
    ("Plant3DOF", {"y": "20 mm"}, {"parameters": {"C3": 9e4}}, ["Plant3DOF", "y", "20 mm", "191 m/s²"]),
    ("Plant3DOF", {"y": "20 mm"}, {"parameters": {"C4": 0.0, "C5": 0.0}}, ["Plant3DOF", "y", "20 mm", "0 m/s²"]),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"C1": 0.0}}, ["Plant2DOF", "v", "20 mm", "h", "0.1 m/s²"]),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"C1": 5e-324}}, ["Plant2DOF", "v", "20 mm", "h", "0.1 m/s²"]),
    ("Plant2DOF", {"v": "20 mm"}, {"hold": 1e300}, ["Plant2DOF", "1e+300 s"]),
    ("Plant2DOF", {"v": "20 mm"}, {"hold": 1000.0}, ["Plant2DOF", "1000 s"]),
    ("Plant3DOF", {"y": "20 mm"}, {"parameters": {"alpha.amplifier.lag": 5e-324}}, ["Plant3DOF", "overflows"]),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"v.locked": True}}, ["Plant2DOF", "v.locked", "true"]),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"v.mass": "4 N"}}, ["Plant2DOF", "v.mass", "'4 N'", "kg"]),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"v.mass": -1.0}},
     ["Plant2DOF", "v.mass", "-1 kg", "0.001", "1e+06 kg"]),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"C2": "4 N"}}, ["Plant2DOF", "C2", "'4 N'", "m/(s2.T2)"]),
    ("Plant2DOF", {"v": "20 mm"}, {"parameters": {"v.locked": 1.0}}, ["v.locked", "1.0", "true", "false"]),
    ("Plant2DOF", {"v": "20 mm"}, {"hold": 0.0}, ["Plant2DOF", "sample time", "0.0 s"]),
    ("Plant2DOF", {"v": "20 mm"}, {"hold": "1 mm"}, ["Plant2DOF", "hold", "'1 mm'", "s"]),
    ("Plant2DOF", {"v": "20 mm"}, {"currents": "dk"}, ["currents", "'dk'", "dq, phases"]),
    ("PID2DOF", {"v": "20 mm"}, {"hold": 1e-3}, ["PID2DOF", "hold", "0.001"]),
    ("Regulator3DOF", {"y": "31 mm"}, {}, ["alpha.i_d_cmd", "-4.53 A", "current_limit", "4 A"]),
    ("LinearRegulator3DOF", {"y": "25 mm"}, {"parameters": {"setpoint": "9 mm", "C3": 2700.0, "current_limit": 0.0}},
     ["LinearRegulator3DOF", "setpoint", "0.009 m"]),
    ("PID2DOF", {"v": "20 mm"}, {"parameters": {"v.prefilter": 9000.0}}, ["PID2DOF", "v.prefilter", "9000.0 rad/s"]),
    ("Regulator2DOF", equilibrium("Plant3DOF", {"y": "25 mm"}), {}, ["own stage", "motor"])])
def test_one_line(name: str, at: Any, options: dict[str, Any], facts: list[str]) -> None:
    with raises(LinearModelError, *facts):
        linearise(name, at, **options)


@pytest.mark.parametrize(("arguments", "facts"), [
    (["Plant3DOF", "--at", "y"], ["--at", "y", "y=25mm"]),
    (["Plant3DOF", "--at", "y=25mm", "--set", "y.mass=7kg"],
     ["set", "y.mass", "7kg", "plant", "controller", "measurement"]),
    (["Plant3DOF", "--at", "y=25mm", "--set", "controller.C3=1"], ["--set", "controller.C3", "Plant3DOF"]),
    (["Plant3DOF", "--at", "y=25mm", "--plot"], ["--open", "--measure", "--plot"]),
    (["Plant3DOF", "PID3DOF", "--at", "y=25mm", "--forces"], ["--forces", "one model"]),
    (["Plant3DOF", "PID3DOF", "Plant3DOF", "--at", "y=25mm"], ["'PID3DOF'", "measurement"]),
    (["PID3DOF", "Plant3DOF", "--at", "y=25mm"], ["'PID3DOF'", "plant", "Plant2DOF, Plant3DOF"]),
    (["PlantMine", "--at", "y=25mm"], ["'PlantMine'", "Measurement5DOF", "mine.toml"]),
    (["PlantMine", "PID3DOF", "--at", "y=25mm"], ["'PlantMine'", "plant", "Plant2DOF, Plant3DOF, Plant5DOF"]),
    (["Plant3DOF", "PIDMine", "--at", "y=25mm"], ["'PIDMine'", "controller", "mine.toml"]),
    (["Plant3DOF", "PID4DOF", "--at", "y=25mm"], ["'PID4DOF'", "controller"]),
    (["Plant3DOF", "PID2DOF", "--at", "y=25mm"], ["own stage", "motor"]),
    (["Plant3DOF", "PID3DOF", "--at", "y=25mm", "--open", "v"], ["'v'", "y.measured"])])
def test_one_line_at_the_command_line(arguments: list[str], facts: list[str]) -> None:
    require_facts(error_line(maglev("linearise", *arguments)), *facts)
