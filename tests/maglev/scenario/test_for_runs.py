"""FMUs that runs need: built where they are missing, kept by content, and without them in the way that is left."""

import json
import os
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from command_line import error_line
from command_line import maglev as command
from facts import raises, warns

import maglev
from maglev.cosim.step_loop import LIBRARY, build_loop, own_loop
from maglev.descriptions.registry import known_stages
from maglev.files.cache import BLOCK_LOOPS, PLACE, keep
from maglev.files.errors import BuildError, ScenarioError
from maglev.fmi.native_build import host_platform
from maglev.language.errors import ExportError
from maglev.scenario import fmus_for_runs as for_runs
from maglev.scenario.catalogue import HOST, PYTHON
from maglev.scenario.fmus_for_runs import fmu_key, fmus_for_runs
from maglev.user.adoption import know_stage

pytestmark = pytest.mark.usefixtures("slow")

SHORT = 'extends = "2dof-setpoints.toml"\nname = "short"\nstop_time = "0.1 s"\nclaims = []\n'


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A user's folder with a scenario, and a cache with nothing in it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(PLACE, str(tmp_path / "cache"))
    (tmp_path / "short.toml").write_text(SHORT, encoding="utf-8")
    yield tmp_path
    known_stages().forget("mine")


@pytest.fixture
def no_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(for_runs, "find_spec", lambda _: None)


def builds(text: str) -> list[str]:
    """What is said to be built."""
    return [line for line in text.splitlines() if "are built" in line]


def kinds(run: maglev.Run) -> set[str]:
    assert run.result.provenance is not None
    return {fmu.kind for fmu in run.result.provenance.fmus}


def test_a_run_builds_what_it_needs_and_no_more_than_once(here: Path, no_compiler: None) -> None:
    first, second = command("run", "short.toml"), command("run", "short.toml", "--out", "again")
    assert first.exit_code == second.exit_code == 0, first.output + second.output
    assert first.stderr.splitlines() == ["maglev: Regulator2DOF, Plant2DOF: Python FMUs are built, once for all runs"]
    assert not second.stderr
    assert sorted(path.name.partition("-")[2] for path in (here / "cache").rglob("*.fmu")) == [
        "Plant2DOF.fmu", "Regulator2DOF.fmu"]
    about = json.loads((here / "results" / "short.json").read_text(encoding="utf-8"))["provenance"]
    assert not about["modified"]
    assert [fmu["file"] for fmu in about["fmus"]] == ["Regulator2DOF.fmu", "Plant2DOF.fmu"]
    assert (here / "results" / "short.csv").read_bytes() == (here / "again" / "short.csv").read_bytes()
    assert not (here / "fmus").exists()


def test_what_a_controller_takes_the_place_of_is_not_built(no_compiler: None) -> None:
    result = command("run", "short.toml", "--controller", "PID2DOF")
    assert builds(result.stderr) == ["maglev: Plant2DOF, PID2DOF: Python FMUs are built, once for all runs"]


def test_native_where_there_is_a_compiler_with_the_same_bits(here: Path, native_fmus: Path, own_cache: Path) -> None:
    with warns("Regulator2DOF", "Plant2DOF", "native"):
        native = maglev.run("short.toml")
    with warns("Regulator2DOF", "Plant2DOF", "Python"):
        python = maglev.run("short.toml", kind="python")
    assert (kinds(native), kinds(python)) == ({"native"}, {"Python"})
    assert native["plant.v.position"].tobytes() == python["plant.v.position"].tobytes()


def test_an_edited_stage_is_rebuilt(here: Path, no_compiler: None) -> None:
    maglev.new_stage("mine.toml", "2dof")
    (here / "mine-short.toml").write_text(SHORT.replace("2dof", "mine"), encoding="utf-8")
    text = (here / "mine.toml").read_text(encoding="utf-8")
    built = []
    for mass in ("4.35", "4.4", "4.35"):
        (here / "mine.toml").write_text(text.replace("mass = 4.35 ", f"mass = {mass} "), encoding="utf-8")
        result = command("run", "mine-short.toml")
        assert result.exit_code == 0, result.output
        built += [len(builds(result.stderr))]
    assert built == [1, 1, 0], "what is as it was is there"


def test_a_stage_that_cannot_work_is_refused_before_it_is_built(here: Path, no_compiler: None) -> None:
    maglev.new_stage("mine.toml", "2dof")
    (here / "mine-short.toml").write_text(SHORT.replace("2dof", "mine"), encoding="utf-8")
    text = (here / "mine.toml").read_text(encoding="utf-8")
    (here / "mine.toml").write_text(text.replace("mass = 4.35 ", "mass = 435 "), encoding="utf-8")
    result = command("run", "mine-short.toml")
    assert result.exit_code == 2
    assert "mine.toml: " in result.stderr and not (here / "cache").exists(), result.stderr


def test_a_key_follows_the_sources(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    maglev.new_stage("mine.toml", "2dof")
    know_stage("mine.toml")
    keys = {fmu_key(name, kind) for name in ("Plant2DOF", "PlantMine") for kind in (PYTHON, HOST, HOST._replace(fmi=3))}
    assert len(keys) == 6
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1")
    assert fmu_key("Plant2DOF", PYTHON) not in keys
    monkeypatch.setattr(for_runs, "dependencies", lambda: ("another version",))
    assert fmu_key("Plant2DOF", PYTHON) not in keys


def test_a_changed_file_is_rebuilt(here: Path, no_compiler: None) -> None:
    with warns("PID2DOF", "Python"):
        fmus_for_runs(["PID2DOF"])
    path, = (here / "cache").rglob("*.fmu")
    content = path.read_bytes()
    path.write_bytes(content[:-1])
    with warns("PID2DOF", "Python"):
        folder = fmus_for_runs(["PID2DOF"])
    assert path.read_bytes() == (folder / "PID2DOF.fmu").read_bytes() == content


def test_two_that_build_at_once_do_not_meet(here: Path) -> None:
    code = ("from maglev.scenario.fmus_for_runs import fmus_for_runs\n"
            "print((fmus_for_runs(['PID2DOF'], kind='python') / 'PID2DOF.fmu').stat().st_size)")
    running = [subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env={
        **os.environ, "PYTHONPATH": str(Path(maglev.__file__).parents[1])}) for _ in range(2)]
    sizes = [process.communicate()[0] for process in running]
    assert [process.returncode for process in running] == [0, 0]
    path, = (here / "cache").rglob("*.fmu")
    assert sizes == [f"{path.stat().st_size}\n"] * 2
    assert [each.name for each in path.parent.iterdir()] == [path.name]


def test_a_compiler_that_fails_leaves_python(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuses(*_: object) -> None:
        raise ExportError("the C compiler refuses the sources")

    monkeypatch.setattr(for_runs, "find_spec", lambda _: "there")
    monkeypatch.setattr("maglev.scenario.catalogue.build_native_fmu", refuses)
    result = command("run", "short.toml")
    assert result.exit_code == 0, result.output
    assert "maglev: the C compiler refuses the sources; runs use FMUs in Python instead" in result.stderr
    with pytest.warns(UserWarning), raises(BuildError, "C compiler"):
        fmus_for_runs(["Plant2DOF"], kind="native")


@pytest.fixture
def shipped(native_fmus: Path, here: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What the wheel of a release brings, of one loop."""
    loop = here / "shipped" / "step_loop" / next(iter(host_platform(3))) / LIBRARY
    for path in (here / "shipped" / "native", loop.parent):
        path.mkdir(parents=True)
    for name in ("Plant2DOF", "Regulator2DOF"):
        shutil.copy(native_fmus / f"{name}.fmu", here / "shipped" / "native")
    shutil.copy(build_loop().path, loop)
    (here / "cache").rename(here / "before")
    monkeypatch.setattr(for_runs, "SHIPPED", here / "shipped")
    return here / "shipped"


def test_the_wheel_of_a_release_needs_no_compiler(shipped: Path, here: Path, native_fmus: Path,
                                                  no_compiler: None) -> None:
    assert own_loop() is None
    result = command("run", "short.toml")
    assert (result.exit_code, result.stderr) == (0, "")
    assert own_loop() is not None
    run = maglev.run("short.toml")
    assert kinds(run) == {"native"}
    assert run["plant.v.position"].tobytes() == maglev.run("short.toml", fmus=native_fmus)["plant.v.position"].tobytes()


def test_the_live_page_needs_none_either(here: Path, wasm_fmus: Path, monkeypatch: pytest.MonkeyPatch,
                                         no_compiler: None) -> None:
    shutil.copytree(wasm_fmus, here / "shipped" / "wasm")
    monkeypatch.setattr(for_runs, "SHIPPED", here / "shipped")
    result = command("live", "short.toml")
    assert (result.exit_code, result.stderr) == (0, ""), result.output
    assert (here / "results" / "live-short.html").stat().st_size > 100_000
    (here / "shipped" / "wasm" / "Plant2DOF.xml").write_text("<fmiModelDescription/>", encoding="utf-8")
    monkeypatch.setenv(PLACE, str(here / "another"))
    assert "is not the Plant2DOF that this installation builds" in error_line(command("live", "short.toml"))


def test_what_is_shipped_and_of_other_sources_does_not_run(shipped: Path, no_compiler: None) -> None:
    with zipfile.ZipFile(shipped / "native" / "Plant2DOF.fmu", "a") as changed:
        changed.writestr("sources/more.c", "int more;\n")
    result = command("run", "short.toml")
    assert result.exit_code == 0
    assert "native/Plant2DOF.fmu was built from other sources" in result.stderr
    assert "runs use FMUs in Python instead" in result.stderr


@pytest.mark.parametrize("lost", ["file", "home"])
def test_without_a_cache_it_is_built_for_the_command(here: Path, monkeypatch: pytest.MonkeyPatch, no_compiler: None,
                                                     lost: str) -> None:
    """Where a file lies in the way, or where there is no home folder: one line, and it runs."""
    if lost == "file":
        (here / "cache").write_text("in the way", encoding="utf-8")
    else:
        monkeypatch.delenv(PLACE)
        monkeypatch.setenv("HOME", "")
        monkeypatch.setattr("platformdirs.user_cache_path", no_home)
    result = command("run", "short.toml")
    assert result.exit_code == 0, result.output
    building, line = result.stderr.splitlines()
    assert "are built" in building
    assert line.endswith("it is for this command alone. MAGLEV_CACHE sets another folder")
    assert sorted(path.name for path in here.iterdir() if path.name not in ("cache", "short.toml")) == ["results"]


def no_home(*_: object, **_options: object) -> Path:
    raise RuntimeError("could not determine the home directory")


def test_refuses_unknown_kinds() -> None:
    with raises(ScenarioError, "kind", "nativ", "python", "native"):
        fmus_for_runs([], kind="nativ")
    with raises(ScenarioError, "fmi", "3", "2", "kind", "native"):
        fmus_for_runs([], kind="python", fmi=3)


def test_a_folder_that_is_named_is_taken_as_it_is(here: Path) -> None:
    assert fmus_for_runs(["Plant2DOF"], "mine") == Path("mine")
    assert fmus_for_runs(["Plant2DOF"], "mine", "native") == Path("mine/native")
    assert fmus_for_runs(["Plant2DOF"], "mine", fmi=3) == Path("mine/fmi3")
    said = error_line(command("run", "short.toml", "--fmus", "nowhere"))
    assert "there is no file nowhere/Regulator2DOF.fmu" in said
    assert not (here / "cache").exists()


def test_the_cache_is_shown_and_cleared(here: Path, no_compiler: None) -> None:
    assert "0 files, 0.0 MB" in command("cache").output
    command("run", "short.toml")
    (here / "cache" / "of others").write_text("stays", encoding="utf-8")
    keep(f"{BLOCK_LOOPS}/of blocks", "loop.so", b"a loop")
    shown = command("cache").output
    assert shown.startswith(f"{here / 'cache'}: 3 files, ")
    assert "cleared" not in shown
    assert command("cache", "--clear").output.endswith(", cleared\n")
    assert [path.name for path in (here / "cache").iterdir()] == ["of others"]
    assert builds(command("run", "short.toml").stderr)
