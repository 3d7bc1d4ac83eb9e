"""Use what a release ships as somebody would who has no compiler: `python tools/try_release.py dist`.

The wheel goes into an empty environment, without the extra `native`, and brings native FMUs; those of FMI 3.0 come from
the archive. Runs are compared with their baselines. It needs a network, for the dependencies, and runs on Linux, macOS
and Windows.
"""

import os
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

# One for each stage, and a law that ends in the stops: what a mathematical library does differently shows there first.
RUNS = ("2dof-smooth-nonlinear", "3dof-setpoints-improved", "5dof-setpoints")


def main() -> None:
    dist, = map(Path, sys.argv[1:]) or (Path("dist"),)
    wheel, = dist.absolute().glob("*.whl")
    native, = dist.absolute().glob("*-native.zip")
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        venv.create(home / "environment", with_pip=True)
        python = home / "environment" / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
        kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}

        def said(*arguments: str | Path) -> None:
            print("$", *arguments, flush=True)
            subprocess.run([python, "-m", *arguments], cwd=home, env=kept, check=True)

        said("pip", "install", "--quiet", "--disable-pip-version-check", wheel)
        said("maglev", "check", "--kind", "native", *RUNS)
        said("maglev", "build", "--kind", "native", "--fmi", "3", "--from", native)
        said("maglev", "check", "--fmus", "fmus", "--kind", "native", "--fmi", "3", *RUNS)
        said("maglev", "build", "--kind", "native", "--fmi", "3", "--clocked", "--from", native)
        said("maglev", "check", "--fmus", Path("fmus", "clocked"), RUNS[0])
        said("maglev", "run", RUNS[0])


if __name__ == "__main__":
    main()
