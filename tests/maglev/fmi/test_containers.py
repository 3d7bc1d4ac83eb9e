"""FMUs of FMI 3.0 in a container that another tool makes, which steps them with event mode."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import fmpy
import numpy as np
import pytest

from maglev.cosim.master import FmuSetup, Master

SAMPLE, STEPS = 0.2e-3, 1000   # s
JUMPED = np.arange(STEPS + 1) >= 50
GAPS, TRAVELS = np.where(JUMPED, 0.0255, 0.025), np.where(JUMPED, 1e-3, 0.0)   # m, references
WIRES = {**{f"{motor}.i_{phase}_cmd": ("Regulator3DOF", "Plant3DOF", f"{motor}.i_{phase}_cmd")
            for motor in ("alpha", "beta") for phase in "abc"},
         **{f"{axis}.encoder": ("Plant3DOF", "Regulator3DOF", f"{axis}.measured") for axis in "yxz"}}
POSITIONS = ("y.position", "x.position")


@pytest.fixture(scope="module")
def pair(fmi3_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with plant and regulator as FMI 3.0, for containers of them."""
    folder = tmp_path_factory.mktemp("pair")
    for name in ("Plant3DOF", "Regulator3DOF"):
        shutil.copy(fmi3_fmus / f"{name}.fmu", folder)
    return folder


def contained(pair: Path, *options: str) -> Path:
    """The container of plant and regulator."""
    pytest.importorskip("fmu_manipulation_toolbox", reason="fmu-manipulation-toolbox is not installed")
    rows = ["rule;from_fmu;from_port;to_fmu;to_port", "FMU;Regulator3DOF.fmu;;;", "FMU;Plant3DOF.fmu;;;",
            "INPUT;;y.position_start;Plant3DOF.fmu;y.position_start",
            *(f"LINK;{source}.fmu;{output};{target}.fmu;{port}" for output, (source, target, port) in WIRES.items())]
    (pair / "c.csv").write_text("\n".join(rows) + "\n")
    command = Path(sys.executable).with_name("fmucontainer")
    done = subprocess.run([command, "-container", f"c.csv:{SAMPLE}", "-fmi", "3", *options], cwd=pair,
                          capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout[-2000:]
    return pair / "c.fmu"


@pytest.mark.skipif(sys.platform != "linux" or os.uname().machine != "x86_64", reason="the tool is for x86-64")
@pytest.mark.parametrize("options", [(), ("-sequential",)])
def test_a_container_steps_both(pair: Path, options: tuple[str, ...]) -> None:
    """Its result is our master's, bit for bit, in either of its orders: it samples at the end of a step.

    So it sets what comes from outside, the references, a sample late; from inside nothing is late.
    """
    given = np.zeros(STEPS + 1, dtype=[("time", float), ("y.reference", float), ("x.reference", float)])
    given["time"] = np.arange(STEPS + 1) * SAMPLE
    given["y.reference"], given["x.reference"] = GAPS, TRAVELS
    simulated = fmpy.simulate_fmu(contained(pair, *options), stop_time=STEPS * SAMPLE, step_size=SAMPLE, input=given,
                              output_interval=SAMPLE, start_values={"y.position_start": 0.027}, output=POSITIONS,
                              fmi_type="CoSimulation")
    drives = {f"Regulator3DOF.{axis}.reference": np.concatenate((values[:1], values[:-1])).tolist()
              for axis, values in (("y", GAPS), ("x", TRAVELS))}
    participants = [FmuSetup(name, pair / f"{name}.fmu", start) for name, start in
                    (("Regulator3DOF", {}), ("Plant3DOF", {"y.position_start": 0.027}))]
    connections = [(f"{source}.{output}", f"{target}.{port}") for output, (source, target, port) in WIRES.items()]
    with Master(participants, connections, SAMPLE) as master:
        ours = master.run(STEPS * SAMPLE, drives).columns
    for name in POSITIONS:
        assert np.ptp(simulated[name]) > 2e-4
        assert np.array_equal(simulated[name], ours[f"Plant3DOF.{name}"])
