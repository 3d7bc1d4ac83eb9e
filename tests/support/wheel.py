"""The wheel in an environment of its own, and programs from it."""

import os
import shutil
import subprocess
import sys
import sysconfig
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from maglev.files.packages import PACKAGES

ROOT = Path(__file__).parents[2]
NOT_SHIPPED = shutil.ignore_patterns("__pycache__")


def setuptools_release() -> int:
    """Release of the interpreter's setuptools; 0 without one."""
    try:
        return int(version("setuptools").split(".")[0])
    except PackageNotFoundError:
        return 0


def install(folder: Path) -> None:
    """Build the wheel into a folder and install it there into an environment that has the dependencies behind it."""
    source = folder / "source"   # a copy, for setuptools leaves a folder build, from which it also ships what is old
    for package in [*PACKAGES, "stages", "scenarios"]:
        shutil.copytree(ROOT / package, source / package, ignore=NOT_SHIPPED)
    for file in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / file, source)
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    alone = ["--no-build-isolation"] if setuptools_release() >= 77 else []   # the one that pyproject.toml asks for
    subprocess.run([*pip, "wheel", "--no-deps", *alone, "--wheel-dir", folder, source], check=True)
    environment = folder / "environment"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", environment], check=True)
    wheel, = folder.glob("*.whl")
    subprocess.run([*pip, "--python", environment / "bin" / "python", "install", "--no-deps", "--no-index", wheel],
                   check=True)
    packages, = environment.glob("lib/python*/site-packages")
    # A folder that is named so is searched last, and its own .pth files, such as one to the repository, are not read.
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")


def ran(installed: Path, home: Path, program: str | Path, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """A program of the environment as it ended, in the user's folder."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    return subprocess.run([installed / "environment" / "bin" / program, *arguments], cwd=home, env=kept,
                          capture_output=True, text=True)


def said(installed: Path, home: Path, *arguments: str | Path) -> str:
    """What such a program writes; it must succeed."""
    done = ran(installed, home, *arguments)
    assert done.returncode == 0, f"{done.stdout[-2000:]}{done.stderr[-2000:]}"
    return done.stdout
