"""The agent that learns: it holds what it has not seen, and its file is a controller that does as it did."""

import re
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from example_builds import EXAMPLES

import maglev


@pytest.mark.thorough
def test_it_learns_and_becomes_a_controller(native_fmus: Path, tmp_path: Path) -> None:
    (tmp_path / "native").symlink_to(native_fmus)
    done = subprocess.run([sys.executable, str(EXAMPLES / "gym_levitate.py"), "--fmus", str(tmp_path), "--out",
                           str(tmp_path / "learned.py"), "--generations", "8", "--units", "1"],
                          capture_output=True, text=True, timeout=300.0, check=False)
    assert done.returncode == 0, done.stderr
    means = [float(each) for each in re.findall(r"mean +([\d.]+) of 500", done.stdout)]
    assert len(means) == 8 + 16
    assert means[0] < 150.0 and means[7] > 400.0 and means[-1] > 450.0
    held = re.findall(r"(\w+): (\d+) of 20 episodes of 5 s held", done.stdout)
    assert [what for what, count in held if int(count) >= 18] == ["linear", "network"]
    *_, error = re.findall(r"v ([\d.]+) mm", done.stdout)
    run = maglev.run("2dof-setpoints", controller=tmp_path / "learned.py", fmus=native_fmus)
    assert run.metrics is not None and not run.metrics.failed
    late = np.concatenate([(run["plant.v.position"] - run["controller.v.reference"])[
        (run.time > end - 0.2) & (run.time < end - 0.01)] for end in (6.0, 11.0, 16.0, 21.0, 26.0)])
    # Setpoints of 5 s instead of 1 s leave it time; it is the law of the environment, not another one.
    assert 1e3 * np.sqrt(np.mean(late**2)) < 2.0 * float(error)


def test_the_file_computes_the_outputs_of_the_network() -> None:
    """Scales and middle of the inputs are part of the weights in the file; the currents are the same."""
    example = runpy.run_path(str(EXAMPLES / "gym_levitate.py"))
    random = np.random.default_rng(0)
    weights = random.standard_normal(example["LINEAR"] + 3 * example["UNIT"])
    space: dict[str, Any] = {}
    exec(example["controller_text"](weights, 9.0, "learned.py"), space)
    law = space["Learned"]()
    law.start()
    parts = np.ones((1, 2, 4))
    sums = np.zeros(2)
    for _ in range(5):
        law.v.reference, law.h.reference = 0.02, 0.0
        law.v.measured, law.h.measured = 0.02 + 2e-3 * random.standard_normal(), 1e-3 * random.standard_normal()
        law.waiting = 0
        law.step(0.0)
        errors = np.array([law.v.reference - law.v.measured, law.h.reference - law.h.measured])
        sums += example["SAMPLE_TIME"] * errors
        parts[0, :, 0], parts[0, :, 1] = errors, sums
        parts[0, :, 2] = law.v.observer.velocity, law.h.observer.velocity
        found = example["agent_currents"](weights[None], parts, np.array([law.v.measured]))[0]
        np.testing.assert_allclose([law.i_d, law.i_q], found, rtol=1e-9)
