"""The action for anybody's CI: what it runs, and what a plain installation, which it makes, brings."""

import subprocess
from importlib.metadata import distribution, packages_distributions
from pathlib import Path
from typing import Any

import yaml  # type: ignore[import-untyped]
from carried_experiments import carrying, files_of
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from wheel import ROOT

from maglev.files.packages import PACKAGES

# Refuses every module that a plain installation does not bring, as one in which it is missing.
PLAIN_ONLY = """
import sys
from importlib.abc import MetaPathFinder


class Missing(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {missing!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
        return None


sys.meta_path.insert(0, Missing())
"""


def steps() -> list[dict[str, Any]]:
    """Steps of the action."""
    found: list[dict[str, Any]] = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))["runs"]["steps"]
    return found


def brought(*names: str) -> set[str]:
    """Distributions that are installed with these, without extras."""
    found: set[str] = set()
    waiting = list(names)
    while waiting:
        name = canonicalize_name(waiting.pop())
        if name not in found:
            found.add(name)
            required = map(Requirement, distribution(name).requires or ())
            waiting += [each.name for each in required if each.marker is None or each.marker.evaluate({"extra": ""})]
    return found


def test_a_plain_installation_brings_little_beside_what_fmpy_users_have() -> None:
    """60 MB at most, of files as they come, on top of NumPy, SciPy and fmpy."""
    more = brought("maglev-fmus") - brought("numpy", "scipy", "fmpy")
    assert {"pythonfmu", "pydantic-core"} <= more
    sizes = {name: sum(path.stat().st_size for file in distribution(name).files or ()
                       if (path := Path(str(file.locate()))).suffix != ".pyc" and path.is_file())
             for name in more - {"maglev-fmus"}}
    own = sum(path.stat().st_size for folder in [*PACKAGES, "scenarios", "stages"]
              for path in (ROOT / folder).rglob("*") if path.is_file() and path.suffix != ".pyc")
    assert 1e6 < own < 60e6 - sum(sizes.values())


def test_the_action_tells_an_fmu_that_repeats_from_one_that_deviates(installed: Path, fmus: Path, tmp_path: Path
                                                                     ) -> None:
    """In a folder with modules of our names, with what a plain installation has."""
    plain = brought("maglev-fmus")
    missing = {module for module, owners in packages_distributions().items()
               if not {canonicalize_name(owner) for owner in owners} & plain}
    assert {"matplotlib", "ziglang", "pytest"} <= missing
    home = tmp_path / "home"
    home.mkdir()
    (home / "plant_fmu.py").write_text("raise ImportError('executed, expected not to be seen')\n", encoding="utf-8")
    (tmp_path / "maglev").mkdir()
    (tmp_path / "maglev" / "sitecustomize.py").write_text(PLAIN_ONLY.format(missing=missing), encoding="utf-8")
    good = carrying(fmus / "Plant2DOF.fmu", home / "good.fmu", files_of(fmus / "Plant2DOF.fmu"))
    files = files_of(good)
    name = "smoke_test_ref.csv"
    assert files[name].count(b",0.02,") > 1
    carrying(good, home / "bad.fmu", {**files, name: files[name].replace(b",0.02,", b",0.03,")})
    for pattern, options, code in (("g*.fmu", "--junit check.xml", 0), ("*.fmu", "", 1), ("none.fmu", "", 2)):
        done = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", steps()[-1]["run"]], cwd=home, text=True,
                              capture_output=True, env={
                                  "PATH": "/usr/bin:/bin", "HOME": str(tmp_path), "RUNNER_TEMP": str(tmp_path),
                                  "PYTHON": str(installed / "environment" / "bin" / "python"), "FMUS": pattern,
                                  "OPTIONS": options})
        assert done.returncode == code, done.stdout + done.stderr
    assert (home / "check.xml").is_file()


def test_the_action_installs_the_plain_package() -> None:
    first, install, check = steps()
    assert first["uses"].startswith("actions/setup-python@")
    assert install["run"].endswith('"$GITHUB_ACTION_PATH"')   # the package, without an extra
    assert "maglev check" in check["run"]
