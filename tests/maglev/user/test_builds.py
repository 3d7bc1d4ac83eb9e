"""FMUs of users' controllers: the same run in all three forms, what they carry, and what cannot become C."""

import zipfile
from importlib import import_module
from pathlib import Path

import pytest
from command_line import error_line, maglev
from facts import raises
from fmpy_validation import validate_fmu
from native_builds import require_native_tools
from written_controllers import controller, line_of, trial

import maglev as tool
from maglev.cosim.fmu import Fmu, read_description
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.scenario.loading import load_plan
from maglev.user.build import importable
from maglev.user.new_controller import new_class
from maglev.user.own_modules import own_modules
from maglev.user.source import FmuFile


# What is written of a controller or a plant differs by what its stage has: most where it tilts.
@pytest.mark.thorough
@pytest.mark.parametrize("stage", [pytest.param(name, marks=[] if stage.rotations else pytest.mark.thorough)
                                   for name, stage in PACKAGED_STAGES.items()])
@pytest.mark.parametrize("kind", ["controller", "plant"])
def test_three_forms_of_one_class(fastest_fmus: Path, tmp_path: Path, stage: str, kind: str) -> None:
    """As file, as FMU that runs Python, and as native FMU: the same bytes."""
    require_native_tools()
    path = new_class(kind, tmp_path / "mine.py", stage)
    forms = [path, *tool.build(path, fmus=tmp_path), *tool.build(path, fmus=tmp_path, kind="native", target="host")]
    run = tmp_path / "short.toml"
    run.write_text(f'extends = "{load_plan(f"{stage}-setpoints").source}"\nname = "short"\nstop_time = "1.2 s"\n')
    written = set()
    for number, form in enumerate(forms):
        assert form.suffix == ".py" or validate_fmu(str(form)) == []
        out = tmp_path / str(number)
        result = maglev("run", run, "--fmus", fastest_fmus, "--out", out, f"--{kind}", form)
        assert result.exit_code == 0, result.output
        written.add((out / "short.csv").read_bytes())
    assert len(forms) == 3
    assert len(written) == 1


MODULES = {
    "messages.py": '"""A name that the C around it has, too."""\n\nHOLDING = -0.25\n',
    "parts/__init__.py": "",
    "parts/limits.py": '''"""Of a package next to the file."""

from .numbers_of_mine import LARGEST


class Limit:
    """Saturation."""

    def __init__(self) -> None:
        self.reached = False

    def limited(self, current: float) -> float:
        """Limit a current (A)."""
        self.reached = current > LARGEST or current < -LARGEST
        if current > LARGEST:
            return LARGEST
        if current < -LARGEST:
            return -LARGEST
        return current
''',
    "parts/numbers_of_mine.py": '"""Numbers."""\n\nLARGEST = 5.0\n'}


def in_modules(folder: Path, name: str = "model.py") -> Path:
    """Write the PD controller with parts of it in modules next to it."""
    for module, text in MODULES.items():
        (folder / module).parent.mkdir(exist_ok=True)
        (folder / module).write_text(text)
    return controller(
        folder,
        ("LARGEST = 6.0\n", "MOST = 6.0\nfrom messages import (\n    HOLDING,\n)\nfrom parts.limits import Limit\n"),
        ("if current > LARGEST:\n        return LARGEST", "if current > MOST:\n        return MOST"),
        ("if current < -LARGEST:\n        return -LARGEST", "if current < -MOST:\n        return -MOST"),
        ("holding = -0.25 +", "holding = HOLDING +"),
        ("self.known = False", "self.known = False\n        self.limit = Limit()"),
        ("limited(holding", "self.limit.limited(holding"), ("limited(travel", "self.limit.limited(travel"), name=name)


def test_carries_modules_next_to_the_file(fastest_fmus: Path, tmp_path: Path) -> None:
    """Also where they are called as the C of our layer is."""
    require_native_tools()
    path, plan = in_modules(tmp_path), trial(tmp_path)
    forms = [path, *tool.build(path, fmus=tmp_path / "built"),
             *tool.build(path, fmus=tmp_path / "built", kind="native", target="host")]
    for module in MODULES:
        (tmp_path / module).rename(tmp_path / f"{module}.gone")
    with raises(tool.ControllerError, "line 7", "ModuleNotFoundError", "'messages'"):
        tool.run(plan, controller=path, fmus=fastest_fmus)
    with pytest.warns(UserWarning):
        runs = [tool.run(plan, controller=form, fmus=fastest_fmus) for form in forms[1:]]
    assert runs[0]["plant.v.position"][-1] == pytest.approx(21e-3, abs=0.3e-3)
    assert runs[0]["plant.v.position"].tobytes() == runs[1]["plant.v.position"].tobytes()


def test_modules_keep_names_of_their_own(tmp_path: Path) -> None:
    """Whatever letters an FMU has in their place; and a package goes before a file of its name, as in Python."""
    for name, gain in (("lib/gains.py", 10.0), ("lib_gains.py", 20.0), ("gäins.py", 30.0), ("g_ins.py", 40.0),
                       ("both.py", 50.0), ("both/__init__.py", 60.0)):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(f"GAIN = {gain}\n", encoding="utf-8")
    path = controller(tmp_path, ("LARGEST = 6.0\n", "LARGEST = 6.0\nimport both\nimport g_ins\nimport gäins\n"
                                 "import lib_gains\nfrom lib.gains import GAIN\n"))
    modules = own_modules(path).modules
    texts = [module.text for module in modules.values()]
    assert len({*texts}) == 6
    with importable({name: module.renamed for name, module in modules.items()}):
        main = import_module(next(iter(modules)))
        found = [main.GAIN, *(getattr(main, name).GAIN for name in ("lib_gains", "gäins", "g_ins", "both"))]
    assert found == [10.0, 20.0, 30.0, 40.0, 60.0]


@pytest.mark.usefixtures("slow")
def test_names_modules_that_are_not_carried(tmp_path: Path) -> None:
    path = controller(tmp_path, ("LARGEST = 6.0\n", "import numpy as np\n\nLARGEST = float(np.float64(6.0))\n"))
    result = maglev("build", path, "--fmus", tmp_path)
    assert result.exit_code == 0, result.output
    assert f"{tmp_path / 'PD.fmu'} does not contain numpy: the Python of who imports it needs it" in result.stderr
    with zipfile.ZipFile(tmp_path / "PD.fmu") as archive:
        assert "with the packages numpy" in archive.read("documentation/externalDependencies.txt").decode()
        description = archive.read("modelDescription.xml").decode()
    assert "copyright" not in description   # it is not ours


@pytest.mark.usefixtures("slow")
def test_builds_are_reproducible(tmp_path: Path) -> None:
    path = controller(tmp_path)
    first, second = (tool.build(path, fmus=tmp_path / name)[0] for name in ("first", "second"))
    assert first.read_bytes() == second.read_bytes()


@pytest.mark.usefixtures("slow")
def test_the_state_is_saved_and_restored(tmp_path: Path) -> None:
    """Attributes of any kind, and parts: what comes after the restored state is what came after it before."""
    path = controller(tmp_path, ("self.known = False", "self.known = False\n        self.seen = []"),
                      ("        self.known = True", "        self.known = True\n        self.seen.append(t)\n"
                       "        self.motor_i_b_cmd = 0.001 * len(self.seen)"),
                      ("self.motor_i_b_cmd = cos(angle - 2.0", "unused = cos(angle - 2.0"))
    fmu_file, = tool.build(path, fmus=tmp_path)
    with Fmu("pd", FmuFile(fmu_file), read_description("pd", fmu_file)) as fmu:
        fmu.initialise({"v.measured": 21e-3}, 0.0, 1.0)
        instance = fmu.instance
        references = [fmu.variables[name].valueReference for name in ("motor.i_a_cmd", "motor.i_b_cmd")]

        def three_steps(begin: int) -> list[float]:
            values = []
            for k in range(begin, begin + 3):
                instance.setReal([fmu.variables["v.measured"].valueReference], [21e-3 - 1e-4 * k])
                instance.doStep(currentCommunicationPoint=0.5e-3 * k, communicationStepSize=0.5e-3)
                values += instance.getReal(references)
            return values

        three_steps(0)
        state = instance.getFMUstate()
        serialized = instance.serializeFMUstate(state)
        after = three_steps(3)
        instance.setFMUstate(state)
        assert three_steps(3) == after
        instance.setFMUstate(instance.deSerializeFMUstate(serialized))
        assert three_steps(3) == after
        assert after[1::2] == pytest.approx([0.004, 0.005, 0.006])


MISFITS = {
    "power": (("w = self.bandwidth", "w = self.bandwidth ** 1.0"), "** 1.0", "**: expected a product"),
    "list": (("self.known = True", "self.known = [0.0]"), "= [0.0]", "a new list: expected one that __init__ sets"),
    "shared": (("self.known = False", "self.known = False\n        self.seen = [0.0]\n        self.more = self.seen"),
               "self.more = self.seen", "self.more is the same object as self.seen"),
    "raise": (("        w = self.band", "        if t < 0.0:\n            raise ValueError\n        w = self.band"),
              "raise ValueError", "raise: expected"),
    "whole number": (("self.damping = 0.9", "self.damping = 1"), "self.damping = 1", "starts as 1: expected 1.0"),
    "another type": (("self.known = True", "self.known = 1.0"), "self.known = 1.0", "starts as a Boolean"),
    "no such name": (("w = self.bandwidth", "w = self.bandwith"), "self.bandwith", "self.bandwith is no attribute")}


@pytest.mark.parametrize("case", MISFITS)
def test_the_line_that_cannot_be_c(slow: None, tmp_path: Path, case: str) -> None:
    """Also where it stands after the tables, which the C has not."""
    require_native_tools()
    change, part, message = MISFITS[case]
    path = controller(tmp_path, change)
    line = error_line(maglev("build", path, "--kind", "native", "--target", "host", "--fmus", tmp_path))
    assert line.startswith(f"maglev: pd.py, line {line_of(path, part)}: ")
    assert message in line
    assert not (tmp_path / "native" / "PD.fmu").exists()


def test_a_whole_number_that_overflows_ends_a_native_run(fastest_fmus: Path, tmp_path: Path) -> None:
    """Where Python continues with more digits, C says the line."""
    require_native_tools()
    part = "self.n = self.n * 3 + 1"
    path = controller(tmp_path, ("self.known = False", "self.known = False\n        self.n = 1"),
                      ("        self.known = True", f"        self.known = True\n        {part}"))
    native, = tool.build(path, fmus=tmp_path, kind="native", target="host")
    done = maglev("run", trial(tmp_path), "--controller", native, "--fmus", fastest_fmus, "--out", tmp_path / "results")
    assert done.exit_code
    assert f"pd.py, line {line_of(path, part)}: a whole number beyond 2^63" in done.output


@pytest.mark.usefixtures("slow")
def test_ours_are_not_overwritten(tmp_path: Path) -> None:
    path = controller(tmp_path, ("class PD:", "class PID2DOF:"))
    assert "would overwrite an FMU of this project" in error_line(maglev("build", path, "--fmus", tmp_path))
