"""The loop of lanes under sanitizers: no access outside of an array, no undefined operation, whatever ends a run."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import sanitized_lanes
from native_builds import require_command


def lines_of(width: int, fmus: Path, folder: Path) -> list[str]:
    """Digests of the runs in so many lanes; fails the test if a sanitizer objects."""
    gcc = require_command("gcc")
    library = subprocess.run([gcc, "-print-file-name=libasan.so"], capture_output=True, text=True, check=True).stdout
    done = subprocess.run(
        [sys.executable, sanitized_lanes.__file__, str(width), str(fmus)], capture_output=True, text=True, timeout=600,
        env={**os.environ, "LD_PRELOAD": library.strip(), "ASAN_OPTIONS": "detect_leaks=0",
             "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "MAGLEV_CACHE": str(folder)})
    assert done.returncode == 0, done.stderr[-4000:]
    return done.stdout.splitlines()


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform != "linux", reason="the address sanitizer is preloaded as on Linux")
def test_lanes_under_sanitizers_have_the_same_bits_at_every_width(native_fmus: Path, tmp_path: Path) -> None:
    """Lanes are refused, trip and stop at different times, and one gets a value that is not a number."""
    found = {width: lines_of(width, native_fmus, tmp_path) for width in (1, 2, 4, 8)}
    assert [line.split()[0] for line in found[1] if line.endswith("refused")] == ["1", "3", "4", "8"]
    assert [line.split()[0] for line in found[1] if line.endswith("began")] == ["5"]
    assert found[1] == found[2] == found[4] == found[8]
