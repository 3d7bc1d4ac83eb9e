"""FMUs of the examples, built as their readers build them."""

import subprocess
import sys
from pathlib import Path

import pytest
from example_builds import EXAMPLES, require_compiler, script

LOOPS = Path(__file__).parents[2] / "scenarios" / "loops"

STEP = """
extends = "{loop}"
name = "step"
title = "A step of 1 mm"
stop_time = "1 s"
[metrics]
bands = ["0.5 mm"]
[fmus.plant.start]
"v.position_start" = "20 mm"
"h.position_start" = "0 mm"
[[signals]]
to = "controller.v.reference"
kind = "steps"
unit = "mm"
times = [0, 0.3]
values = [20, 21]
[[signals]]
to = "controller.h.reference"
kind = "constant"
value = "0 mm"
[check]
interval = "50 ms"
[check.signals]
"plant.v.position" = {{ absolute = "1 nm" }}
"controller.motor.i_d_cmd" = {{ absolute = "1 uA" }}
[[claims]]
text = "It holds"
source = "here"
metric = "failed"
relation = "is"
target = false
[[claims]]
text = "Commands are small"
source = "here"
metric = "peak_command"
relation = "<"
target = "9 A"
"""


@pytest.fixture
def step(tmp_path: Path) -> Path:
    """A scenario of the 2-DOF stage: from rest, a step of 1 mm."""
    path = tmp_path / "step.toml"
    path.write_text(STEP.format(loop=LOOPS / "2dof.toml"))
    return path


@pytest.fixture(scope="session")
def c_controller(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The PD controller in C."""
    require_compiler()
    built: Path = script(EXAMPLES / "pd_controller_c" / "build.py").build(tmp_path_factory.mktemp("c"))
    return built


@pytest.fixture(scope="session")
def python_controller(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The PD controller in Python."""
    folder = tmp_path_factory.mktemp("python")
    subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f",
                    EXAMPLES / "pd_controller_python" / "pd_controller.py", "-d", folder], check=True,
                   capture_output=True)
    return folder / "PDController.fmu"
