"""Our FMUs in programs that know nothing of this project: plain C without Python, plain fmpy, a container around."""

import logging
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import numpy as np
import pytest
from command_line import maglev
from example_builds import EXAMPLES, require_compiler

from maglev.cosim.master import FmuSetup, Master


@pytest.fixture(scope="session")
def host(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The C program that runs the 3-DOF stage."""
    if not sys.platform.startswith("linux"):
        pytest.skip("the program loads with dlopen from binaries/linux64")
    import fmpy
    program = tmp_path_factory.mktemp("host") / "run"
    done = subprocess.run([*require_compiler(), "-std=c99", "-Wall", "-Wextra", "-O2", "-I",
                           Path(fmpy.__file__).parent / "c-code", EXAMPLES / "plain_c_host" / "run.c", "-o", program,
                           "-ldl", "-lm"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    return program


def unpacked(folder: Path, fmus: Path) -> list[Path]:
    """Folders of the unpacked plant and regulator."""
    places = []
    for name in ("Plant3DOF", "Regulator3DOF"):
        with zipfile.ZipFile(fmus / f"{name}.fmu") as archive:
            archive.extractall(folder / name)
        places.append(folder / name)
    return places


def positions(text: str) -> np.ndarray:
    """Positions that the program wrote, (samples, axes)."""
    return np.array([[float(value) for value in line.split(",")[1:]] for line in text.splitlines()[1:]])


def recorded(fmus: Path, seconds: float) -> np.ndarray:
    """The same run by our master."""
    axes, pairs = "yxz", ("alpha", "beta")
    connections = [*((f"plant.{axis}.encoder", f"controller.{axis}.measured") for axis in axes),
                   *((f"controller.{pair}.i_{phase}_cmd", f"plant.{pair}.i_{phase}_cmd") for pair in pairs
                     for phase in "abc")]
    start = {f"{axis}.position_start": value for axis, value in zip(axes, (25e-3, 0.0, 0.0), strict=True)}
    steps = round(seconds / 0.2e-3)
    drives = {f"controller.{axis}.reference": [0.0] * (steps + 1) for axis in "xz"}
    drives["controller.y.reference"] = [25e-3 if k * 0.2e-3 < 1.0 - 1e-9 else 26e-3 for k in range(steps + 1)]
    with Master([FmuSetup("controller", fmus / "Regulator3DOF.fmu"),
                 FmuSetup("plant", fmus / "Plant3DOF.fmu", start)], connections, 0.2e-3) as master:
        columns = master.run(seconds, drives).columns
    return np.stack([columns[f"plant.{axis}.position"] for axis in axes], axis=1)


def test_native_fmus_run_in_a_process_without_python(native_fmus: Path, host: Path, tmp_path: Path) -> None:
    """3 s, a step of 1 mm after 1 s: bit for bit what our master records."""
    done = subprocess.run([host, *unpacked(tmp_path, native_fmus), "3"], capture_output=True, text=True, env={})
    assert done.returncode == 0, done.stderr
    there, here = positions(done.stdout), recorded(native_fmus, 3.0)
    assert there.shape == (15001, 3)
    assert np.array_equal(there.view(np.int64), here.view(np.int64))
    assert there[-1, 0] == pytest.approx(26e-3, abs=0.1e-3)
    libraries = subprocess.run(["ldd", host, *tmp_path.glob("*/binaries/linux64/*.so")], capture_output=True, text=True)
    assert "python" not in libraries.stdout


@pytest.mark.thorough
def test_pythonfmu_fmus_need_a_python_library_there(fmus: Path, host: Path, tmp_path: Path) -> None:
    """Without LD_PRELOAD the linker says what is missing, with it they run."""
    folders = unpacked(tmp_path, fmus)
    done = subprocess.run([host, *folders, "0.1"], capture_output=True, text=True, env={})
    assert done.returncode == 1
    assert "undefined symbol: _Py" in done.stderr
    library = Path(str(sysconfig.get_config_var("LIBDIR"))) / str(sysconfig.get_config_var("LDLIBRARY"))
    if not library.is_file() or library.suffix == ".a":
        pytest.skip(f"this Python has no shared library ({library})")
    done = subprocess.run([host, *folders, "0.1"], capture_output=True, text=True,
                          env={"LD_PRELOAD": str(library), "PYTHONHOME": sysconfig.get_config_var("prefix")})
    assert done.returncode == 0, done.stderr
    assert np.array_equal(positions(done.stdout), recorded(fmus, 0.1))


@pytest.fixture
def foreign_plant(native_fmus: Path, tmp_path: Path) -> Path:
    """The native plant inside a container that another tool makes: other names of its ports, and no units."""
    pytest.importorskip("fmu_manipulation_toolbox")
    from fmu_manipulation_toolbox.container import FMUContainer
    logging.getLogger("fmu_manipulation_toolbox").setLevel(logging.ERROR)
    made = FMUContainer("Foreign", native_fmus, fmi_version=2)
    model = "Plant2DOF.fmu"
    made.get_fmu(model)
    for phase in "abc":
        made.add_input(f"coil_{phase}", model, f"motor.i_{phase}_cmd")
    for name in ("v.position_start", "h.position_start", "encoder.resolution"):
        made.add_input(name, model, name)
    for theirs, ours in FOREIGN_OUTPUTS.items():
        made.add_output(model, ours, theirs)
    made.make_fmu(tmp_path / "Foreign.fmu", step_size=0.5e-3, sequential=True)
    return tmp_path / "Foreign.fmu"


FOREIGN_OUTPUTS = {"gap_encoder": "v.encoder", "gap": "v.position", "travel_encoder": "h.encoder",
                   "travel": "h.position", "coil_a_is": "motor.i_a", "coil_b_is": "motor.i_b",
                   "coil_c_is": "motor.i_c", "stop": "at_stop"}


def test_our_regulator_holds_a_plant_of_another_tool(native_fmus: Path, foreign_plant: Path, step: Path,
                                                     tmp_path: Path) -> None:
    """The other tool steps our own plant, so that the check finds every bit where it was."""
    common: list[str | Path] = ["check", step, "--fmus", native_fmus, "--baselines", tmp_path / "baselines"]
    assert maglev(*common, "--update").exit_code == 0
    ports = tmp_path / "ports.toml"
    lines = [f'"{ours}" = "{theirs}"' for theirs, ours in FOREIGN_OUTPUTS.items()]
    lines += [f'"motor.i_{phase}_cmd" = "coil_{phase}"' for phase in "abc"]
    ports.write_text("[plant]\n" + "\n".join(lines) + "\n")
    result = maglev(*common, "--plant", foreign_plant, "--map", ports)
    assert result.exit_code == 0, result.output
    assert "3 signals at 21 samples to t = 1 s equal the baseline" in result.output
    wrong = maglev(*common, "--plant", foreign_plant)
    assert wrong.exit_code == 2
    assert "missing ports: output v.encoder (nearest is 'gap_encoder')" in wrong.output
