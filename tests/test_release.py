"""What a release ships: versions that agree, bytes that depend on no machine, native FMUs without a compiler."""

import re
import runpy
import shutil
import tarfile
import tomllib
import zipfile
from pathlib import Path

import numpy as np
import pytest
from command_line import error_line
from command_line import maglev as command
from facts import raises
from fmpy.simulation import Input

import maglev
from maglev.cosim.fmu import read_description
from maglev.cosim.step_loop import LIBRARY, build_loop, own_loop
from maglev.descriptions.own_fmus import built_here, definition
from maglev.fmi.build import write_archive
from maglev.fmi.model_description import model_description
from maglev.fmi.native_build import host_platform
from maglev.runs.carried_experiments import carried_experiments, input_array, run_options
from maglev.runs.experiment_check import expected_results
from maglev.scenario.catalogue import experiments_in

ROOT = Path(__file__).parents[1]
TOOL = ROOT / "tools" / "release.py"


def test_versions_agree() -> None:
    """pyproject.toml has the version; CITATION.cff and the changelog follow."""
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    headings = [line for line in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").splitlines()
                if line.startswith("## ")]
    assert headings[:2] == ["## Unreleased", f"## {version}"]


def test_a_version_begins_in_every_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("pyproject.toml", "CITATION.cff", "CHANGELOG.md"):
        shutil.copy(ROOT / name, tmp_path)
    tool = runpy.run_path(str(TOOL))
    monkeypatch.setitem(tool["begin"].__globals__, "ROOT", tmp_path)
    tool["begin"]("99.0.1")
    assert tool["project_version"]() == "99.0.1"
    assert "\nversion: 99.0.1\n" in (tmp_path / "CITATION.cff").read_text(encoding="utf-8")
    assert "\n## Unreleased\n\n## 99.0.1\n" in (tmp_path / "CHANGELOG.md").read_text(encoding="utf-8")
    for wrong in ("99.0.1", "99.1", "v100.0.0"):
        with raises(SystemExit, wrong):
            tool["begin"](wrong)


def test_a_source_distribution_has_the_date_of_the_commit(tmp_path: Path) -> None:
    tidied = runpy.run_path(str(TOOL))["tidied"]
    for hour, names in ((1.0, ("a.py", "b.py")), (2.0, ("b.py", "a.py"))):
        with tarfile.open(tmp_path / f"{hour}.tar.gz", "w:gz") as archive:
            for name in names:
                info = tarfile.TarInfo(name)
                info.mtime, info.uname = hour, f"user {hour}"
                archive.addfile(info)
        tidied(tmp_path / f"{hour}.tar.gz", tmp_path / f"{hour}-tidied.tar.gz", 1_700_000_000)
    assert (tmp_path / "1.0-tidied.tar.gz").read_bytes() == (tmp_path / "2.0-tidied.tar.gz").read_bytes()
    with tarfile.open(tmp_path / "1.0-tidied.tar.gz") as archive:
        assert [(each.name, each.mtime) for each in archive] == [("a.py", 1_700_000_000), ("b.py", 1_700_000_000)]


@pytest.mark.parametrize(("name", "interface"), [("Plant2DOF", "cs"), ("Plant2DOF", "me"), ("Regulator5DOF", "cs")])
def test_compatibility_information_follows_the_rules_of_fmi_standard_org(
        name: str, interface: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder has the files with their names and limits; their numbers are those of the experiment in the FMU."""
    own, step = definition(name), definition(name).experiment.step
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    write_archive(tmp_path / "native" / f"{name}.fmu", experiments_in(own) | {
        "modelDescription.xml": model_description(own, "{1}", "9.8.7", 0, ["model.c"])})
    folder = runpy.run_path(str(TOOL))["compatibility"](tmp_path / "made")
    assert {path.name for path in (folder / "2.0").iterdir()} == ({"cs", "me"} if own.continuous else {"cs"})
    place = folder / "2.0" / interface / "native" / name
    fmu = place / f"{name}.fmu"
    assert {path.name for path in place.iterdir()} == {
        fmu.name, f"{name}_ref.csv", f"{name}_ref.opt", f"{name}_in.csv", "Readme.txt"}
    for path in place.glob("*.csv"):
        header = path.read_text(encoding="utf-8").splitlines()[0]
        assert re.fullmatch(r'"time"(,"[^"]+")+', header) and path.stat().st_size < 1_000_000
    variables = {v.name: v for v in read_description(name, fmu).modelVariables}
    carried = {each.name: each for each in carried_experiments(fmu)}
    ours, whole = carried[f"{name}_ref.csv"], carried[f"{name}_validation"]
    assert ours.results and ours.inputs and whole.results and whole.inputs
    results, all_results = (expected_results(file, variables, {}, False) for file in (ours.results, whole.results))
    assert len(results.values) == 10
    assert all((results.values[key] == all_results.values[key]).all() for key in results.values)
    assert run_options(ours.options)[0] == {
        "StartTime": 0.0, "StopTime": results.time[-1], "OutputIntervalLength": results.time[1],
        **({"StepSize": step, "RelTol": 1e-6} if interface == "cs" else {"StepSize": 0.0, "RelTol": 1e-8})}
    given, rows = input_array(ours.inputs, variables), input_array(whole.inputs, variables)
    assert given.dtype == rows.dtype
    for instant, row in zip(rows["time"] + (0.5 * step if interface == "me" else 0.0), rows, strict=True):
        table = np.array([given[key] for key in given.dtype.names or ()][1:])
        values, _ = Input.interpolate(instant, given["time"], table)   # a solver sees the same in all of a step
        np.testing.assert_allclose(values, list(row)[1:], rtol=1e-12)
    readme = (place / "Readme.txt").read_text(encoding="utf-8")
    assert all(text in readme for text in (own.description, "Version: 9.8.7\n", "Date: 2023-11-14\n",
                                           "Contact: The authors of Maglev FMUs\n"))


@pytest.fixture
def shipped(native_fmus: Path, tmp_path: Path) -> Path:
    """Archive as a release has it, of one loop, for this machine."""
    path = tmp_path / "maglev-fmus-native.zip"
    with zipfile.ZipFile(path, "w") as archive:
        for name in ("Plant2DOF", "Regulator2DOF"):
            archive.write(native_fmus / f"{name}.fmu", f"native/{name}.fmu")
        archive.write(build_loop().path, f"step_loop/{next(iter(host_platform(3)))}/{LIBRARY}")
    return path


def test_fmus_with_a_clock_go_with_a_plant_without_one(clocked_fmus: Path, tmp_path: Path) -> None:
    """A release has one plant of FMI 3.0, in fmi3, for both."""
    given, made = tmp_path / "given", tmp_path / "made"
    loop = f"step_loop/{next(iter(host_platform(3)))}/{LIBRARY}"
    for file in ("clocked/Regulator3DOF.fmu", "fmi3/Plant3DOF.fmu", loop):
        (given / file).parent.mkdir(parents=True)
        shutil.copy(build_loop().path if file == loop else clocked_fmus / Path(file).name, given / file)
    taken = maglev.build("Stage3DOF", fmus=made, kind="native", fmi=3, clocked=True, source=given)
    assert [path.relative_to(made).as_posix() for path in taken] == [
        f"clocked/{name}" for name in ("Plant3DOF.fmu", "Regulator3DOF.fmu", "Stage3DOF.ssp")]
    assert taken[1].read_bytes() == (clocked_fmus / "Regulator3DOF.fmu").read_bytes()
    with raises(maglev.BuildError, "source", given, "fmi3/Regulator3DOF.fmu"):
        maglev.build("Stage3DOF", fmus=made, kind="native", fmi=3, source=given)


def test_native_fmus_are_taken_without_a_compiler(shipped: Path, native_fmus: Path, tmp_path: Path,
                                                  monkeypatch: pytest.MonkeyPatch) -> None:
    """Out of the archive or a folder, with the system of them and the loop that steps them; others are refused."""
    monkeypatch.setattr("maglev.files.errors.find_spec", lambda name: None if name == "ziglang" else name)
    before = build_loop()
    monkeypatch.setenv("MAGLEV_CACHE", str(tmp_path / "cache"))
    assert own_loop() is None
    made = maglev.build("Stage2DOF", fmus=tmp_path, kind="native", source=shipped)
    assert [path.name for path in made] == [
        "Plant2DOF.fmu", "Regulator2DOF.fmu", "Stage2DOF.ssp", "Stage2DOFNoPorts.ssp"]
    assert all(built_here(path) for path in made[:2])
    taken = own_loop()
    assert taken is not None
    assert (taken.path != before.path, taken.sha256) == (True, before.sha256)
    assert maglev.run("2dof-step-4-nonlinear", fmus=tmp_path, kind="native").verdicts
    unpacked = tmp_path / "unpacked"
    zipfile.ZipFile(shipped).extractall(unpacked)
    shutil.copy(unpacked / "native" / "Plant2DOF.fmu", unpacked / "native" / "PID2DOF.fmu")
    with zipfile.ZipFile(unpacked / "native" / "Plant2DOF.fmu", "a") as changed:
        changed.writestr("sources/more.c", "int more;\n")
    for given, name, wrong in ((unpacked, "Plant2DOF", "built from other sources"), (unpacked, "PID3DOF", "has no "),
                               (shipped, "PID3DOF", "has no "), (ROOT / "README.md", "PID3DOF", "has no ")):
        line = error_line(command("build", "--kind", "native", "--from", given, name, "--fmus", tmp_path / "other"))
        assert wrong in line and f"native/{name}.fmu" in line
    assert not list((tmp_path / "other").rglob("*.fmu"))
    assert "needs kind = native" in error_line(command("build", "--from", shipped))


@pytest.mark.parametrize("path", [*sorted((ROOT / ".github" / "workflows").glob("*.yml")), ROOT / "action.yml"],
                         ids=lambda path: path.name)
def test_actions_are_named_by_their_content(path: Path) -> None:
    """A tag can be moved to other code, a digest cannot; the comment says which version it is."""
    used = re.findall(r"uses: (?!\./)(.*)", path.read_text(encoding="utf-8"))   # not those of this repository
    assert used
    assert all(re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}   # v\d+\.\d+\.\d+", each) for each in used), used
