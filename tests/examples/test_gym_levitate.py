"""The agent that learns: it holds what it has not seen, and its file is a controller that does as it did."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
from example_builds import EXAMPLES

import maglev


def test_it_learns_and_becomes_a_controller(native_fmus: Path, tmp_path: Path) -> None:
    (tmp_path / "native").symlink_to(native_fmus)
    done = subprocess.run([sys.executable, str(EXAMPLES / "gym_levitate.py"), "--fmus", str(tmp_path), "--out",
                           str(tmp_path / "learned.py")], capture_output=True, text=True, timeout=300.0, check=False)
    assert done.returncode == 0, done.stderr
    means = [float(each) for each in re.findall(r"mean +([\d.]+) of 500", done.stdout)]
    assert len(means) == 20
    assert means[0] < 100.0 and means[-1] > 450.0
    held, = re.findall(r"(\d+) of 20 episodes of 5 s held", done.stdout)
    assert int(held) >= 18
    error, = re.findall(r"v ([\d.]+) mm", done.stdout)
    run = maglev.run("2dof-setpoints", controller=tmp_path / "learned.py", fmus=native_fmus)
    assert run.metrics is not None and not run.metrics.failed
    late = np.concatenate([(run["plant.v.position"] - run["controller.v.reference"])[
        (run.time > end - 0.2) & (run.time < end - 0.01)] for end in (6.0, 11.0, 16.0, 21.0, 26.0)])
    # Setpoints of 5 s in place of 1 s leave it time; it is the law of the environment, not another one.
    assert 1e3 * np.sqrt(np.mean(late**2)) < 2.0 * float(error)
