"""The plant with arrays of FMI 3.0."""

import runpy
import sys
from pathlib import Path

import fmpy
import numpy as np
import pytest
from example_builds import EXAMPLES
from fmpy.fmi1 import FMICallException

from maglev.cosim.fmu import Fmu, read_description
from maglev.cosim.master import FmuSetup, Master
from maglev.user.source import FmuFile

STEP, END = 2e-4, 0.04   # s
AXES, MOTORS, PHASES = "yxz", ("alpha", "beta"), "abc"


def test_its_elements_are_the_scalars(fmi3_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In our master, bit for bit, and so in fmpy."""
    monkeypatch.setattr(sys, "argv", ["array_plant.py", str(tmp_path)])
    runpy.run_path(str(EXAMPLES / "array_plant.py"), run_name="__main__")
    path = tmp_path / "ArrayPlant3DOF.fmu"
    names = {f"{axis}.{name}": f"{name}[{k}]" for name in ("position", "velocity", "encoder", "position_start", "force")
             for k, axis in enumerate(AXES, 1)}
    names |= {f"{motor}.i_{phase}{end}": f"i{end}[{row},{column}]" for row, motor in enumerate(MOTORS, 1)
              for column, phase in enumerate(PHASES, 1) for end in ("", "_cmd")}
    start = {"y.position_start": 0.0251, "x.position_start": 1e-3, "z.position_start": -2e-3}
    time = np.arange(round(END / STEP) + 1) * STEP
    drives = {f"{motor}.i_{phase}_cmd": np.sin(40.0 * time + k) for k, (motor, phase) in enumerate(
        (motor, phase) for motor in MOTORS for phase in PHASES)} | {"z.force": 5.0 * np.cos(90.0 * time)}
    with Master([FmuSetup("plant", fmi3_fmus / "Plant3DOF.fmu", start),
                 FmuSetup("arrays", path, {names[each]: value for each, value in start.items()})], [], STEP) as master:
        made = master.run(END, {f"plant.{each}": values.tolist() for each, values in drives.items()}
                        | {f"arrays.{names[each]}": values.tolist() for each, values in drives.items()}).columns
    recorded = [each for each in names if f"plant.{each}" in made]   # outputs, and what is driven
    assert len(recorded) == 3 * 3 + 6 + len(drives) and np.ptp(made["plant.x.position"]) > 1e-6
    for each in recorded:
        assert np.array_equal(made[f"plant.{each}"], made[f"arrays.{names[each]}"]), each
    still = fmpy.simulate_fmu(str(path), stop_time=10 * STEP, step_size=STEP, output_interval=STEP, output=["position"],
                              start_values={"position_start": ["0.0251", "0.001", "-0.002"]})
    assert still["position"].shape == (11, 3) and list(still["position"][0]) == [0.0251, 1e-3, -2e-3]
    with Fmu("arrays", FmuFile(path), read_description("arrays", path)) as fmu:
        reference = {v.name: v.valueReference for v in fmpy.read_model_description(str(path)).modelVariables}
        for values in ([1.0, 2.0], [1.0, 2.0, 1e9]):
            with pytest.raises(FMICallException):
                fmu.instance.setFloat64([reference["force"]], values)
        assert "of 1 variables with 2 values, expected 3; z.force = 1000000000.0 N, expected" in fmu.said()
        assert fmu.instance.getFloat64([reference["force"]], 3) == [0.0, 0.0, 0.0]
