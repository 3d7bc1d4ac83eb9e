"""What is wrong with a user's controller, each in one line that says what to do; no FMU is needed to say it."""

import pickle
import shutil
import zipfile
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest
from command_line import error_line, maglev
from facts import raises, require_facts
from written_controllers import controller, line_of, trial

import maglev as tool
from maglev.scenario.loading import load_plan
from maglev.user.source import PythonClass, PythonFile, read_modules

DECLARED: dict[str, tuple[tuple[str, str], *tuple[str, ...]]] = {
    "an attribute that is not there": (
        ('"v.measured": "m", "h.measured"', '"v.mesured": "m", "h.measured"'),
        "inputs", "'v.mesured'", "self.v.mesured", "self.v_mesured"),
    "no text as a unit": (('{"bandwidth": "rad/s"', '{"bandwidth": None'), "'bandwidth'", "None", "rad"),
    "no table": (("    parameters = {", "    parameters = 3\n    unused = {"), "parameters", "3", "table"),
    "a start that is no number": (("self.damping = 0.9", "self.damping = 'high'"), "damping", "'high'"),
    "a start that is not finite": (("self.damping = 0.9", "self.damping = float('nan')"), "damping", "nan"),
    "one name twice": (('"damping": ""', '"v.measured": "m"'), "parameters", "'v.measured'"),
    "one attribute twice": (('"v.measured": "m", "h.measured"', '"v.measured": "m", "v_measured": "m", "h.measured"'),
                            "v.measured", "v_measured", "self.v_measured"),
    "too many names": (('"v.measured": "m", "h.measured"',
                        '**{f"u{i}": "m" for i in range(2000)}, "v.measured": "m", "h.measured"'), "2009", "2000"),
    "a sample time of 0": (("self.sample_time = 0.5e-3", "self.sample_time = 0.0"), "sample_time", "0.0 s", "0 s"),
    "no sample time": (("self.sample_time = 0.5e-3", "self.time_of_sample = 0.5e-3"), "self.sample_time"),
    "no step": (("def step(", "def stp("), "no step", "step(self, t)"),
    "a step of other arguments": (("def step(self, t: float)", "def step(self, t, dt, u)"),
                                  "step(self, t, dt, u)", "step(self, t)", "step(self, t, dt)"),
    "a start with arguments": (("    def step(", "    def start(self, t):\n        pass\n\n    def step("),
                               "start(self, t)", "start(self)"),
    "an async step": (("    def step(", "    async def step("), "step", "async or yield"),
    "a step that yields": (("        self.known = True", "        yield"), "step", "async or yield"),
    "a start that yields": (("    def step(", "    def start(self):\n        yield\n\n    def step("),
                            "start", "async or yield"),
    "a constructor with arguments": (("self.known = False", "self.known = False\n\n    def __new__(cls, gain): pass"),
                                     "PD(gain)", "without arguments"),
}


@pytest.mark.parametrize("case", DECLARED)
def test_what_a_class_declares(tmp_path: Path, case: str) -> None:
    change, *facts = DECLARED[case]
    path = controller(tmp_path, change)
    with raises(tool.ControllerError, "pd.py", "PD", *facts) as refusal:
        PythonFile(path).load()
    said, tables = str(refusal.value), {"no table": "parameters = 3", "one name twice": '"v.measured": "m", "h.meas',
                                  "one attribute twice": '"v_measured": "m"'}
    word = tables.get(case) or next((f'"{name}":' for name in ("v.mesured", "bandwidth", "damping") if name in said
                                     and "sample_time" not in said), None)
    assert (f"line {line_of(path, word)}" in said) if word else "line" not in said


@pytest.mark.parametrize(("other", "facts"), [
    ("second.py", ["second.py", "PID2DOF", "first.py"]), ("PID2DOF", ["first.py", "PID2dof", "PID2DOF"])])
def test_two_classes_of_one_name_are_not_built_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                                        other: str, facts: list[str]) -> None:
    """The one would take the place of the other's file; some disks know no capital letters."""
    monkeypatch.chdir(tmp_path)
    controller(tmp_path, ("class PD:", "class PID2dof:"), name="first.py")
    controller(tmp_path, ("class PD:", "class PID2DOF:"), name="second.py")
    line = error_line(maglev("build", "first.py", other))
    require_facts(line, *facts)
    assert not (tmp_path / "fmus").exists()


@pytest.mark.parametrize(("beside", "line"), [("controller_fmu.py", "import controller_fmu\n"),
                                              ("plant_fmu/__init__.py", "from plant_fmu import anything\n"),
                                              ("pmlsm/motor.py", "from pmlsm.motor import constants\n")])
def test_a_module_beside_it_has_a_name_of_ours(tmp_path: Path, beside: str, line: str) -> None:
    """Python would take ours in some processes, theirs in others; one that is only there is in nobody's way."""
    other = tmp_path / beside
    other.parent.mkdir(exist_ok=True)
    other.write_text("raise ImportError('executed')\n", encoding="utf-8")
    path = controller(tmp_path)
    assert PythonFile(path).load().file == path
    path.write_text(line + path.read_text(encoding="utf-8"), encoding="utf-8")
    module = beside.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    with raises(tool.ControllerError, other, module):
        PythonFile(path).load()


EXECUTED = {
    "a module that is not there": ("import nowhere_at_all\n", "ModuleNotFoundError", "'nowhere_at_all'"),
    "a name that a module lacks": ("from math import tau_\n", "ImportError", "'tau_'", "'math'"),
    "a crash": ("LARGEST = 6.0 / 0\n", "ZeroDivisionError"),
}


@pytest.mark.parametrize("case", EXECUTED)
def test_a_file_that_cannot_be_executed(tmp_path: Path, case: str) -> None:
    text, *facts = EXECUTED[case]
    path = controller(tmp_path, ("LARGEST = 6.0\n", text))
    with raises(tool.ControllerError, "pd.py", "line 6", *facts):
        PythonFile(path).load()


NESTED = {
    "minus signs": "-" * 100_000 + "1", "a sum": "+".join(["1"] * 300_000), "attributes": "sys" + ".a" * 300_000,
    "parentheses": "(" * 20_000 + "1" + ")" * 20_000}


@pytest.mark.parametrize("case", NESTED)
def test_an_expression_beyond_the_parser(tmp_path: Path, case: str) -> None:
    """Each version of Python has other bounds, and other errors beyond them."""
    path = controller(tmp_path, ("LARGEST = 6.0\n", f"LARGEST = 6.0\ndef unused():\n    return {NESTED[case]}\n"))
    with raises(tool.ControllerError, "pd.py", "nested"):
        PythonFile(path).load()


def test_a_byte_order_mark(tmp_path: Path) -> None:
    """As editors on Windows write it; the FMU of the file has none."""
    path = controller(tmp_path)
    path.write_text(path.read_text(), encoding="utf-8-sig")
    assert PythonFile(path).load().definition.name == "PD"
    assert next(iter(read_modules(path).modules.values())).renamed.startswith('"""PD')


ARITHMETIC = {"1.0 / (t - t)": "ZeroDivisionError", "sin(1.0 / 1e-320)": "ValueError",
              "int(self.known and 1e400)": "OverflowError"}


@pytest.mark.parametrize("expression", ARITHMETIC)
def test_arithmetic_that_fails_has_its_line(fastest_fmus: Path, tmp_path: Path, expression: str) -> None:
    """The layer around the blocks of this project, which have no lines of a user's, catches it as well."""
    path = controller(tmp_path, ("w = self.bandwidth", f"w = {expression}"))
    with raises(tool.RunFailed, "pd.py", f"line {line_of(path, expression)}", ARITHMETIC[expression]):
        tool.run(trial(tmp_path), controller=path, fmus=fastest_fmus)


def test_an_object_that_cannot_be_made(tmp_path: Path) -> None:
    path = controller(tmp_path, ("        self.known = False", "        self.known = [][0]"))
    with raises(tool.ControllerError, "pd.py", "PD()", "IndexError"):
        PythonFile(path).load()


def test_which_class_is_meant(tmp_path: Path) -> None:
    path = controller(tmp_path)
    path.write_text(path.read_text() + "\n\nclass Other(PD):\n    pass\n")
    with raises(tool.ControllerError, "pd.py", "2 classes", "pd.py:PD"):
        PythonFile(path).load()
    assert PythonFile(path, "Other").load().definition.name == "Other"
    with raises(tool.ControllerError, "pd.py:Othr", "'Other'"):
        PythonFile(path, "Othr").load()


def test_a_sample_time_that_does_not_fit(fastest_fmus: Path, tmp_path: Path) -> None:
    path = controller(tmp_path, ("self.sample_time = 0.5e-3", "self.sample_time = 0.7e-3"))
    with raises(tool.RunFailed, "step", "0.0005 s", "sample_time", "0.0007 s"), \
            pytest.warns(UserWarning):
        tool.run(trial(tmp_path), controller=path, fmus=fastest_fmus)


def test_a_class_does_not_run_with_a_third_party_fmu(fastest_fmus: Path, tmp_path: Path) -> None:
    """Such as one that an older version has built: it runs in another process, where the class is not."""
    plan = load_plan(trial(tmp_path))
    old = tmp_path / "old"
    old.mkdir()
    for fmu in plan.fmus.values():
        shutil.copy(fastest_fmus / f"{fmu.model}.fmu", old)
    with zipfile.ZipFile(old / f"{plan.fmus['plant'].model}.fmu", "a") as archive:
        archive.writestr("sources/note.c", "another one")
    spec = spec_from_file_location("pd_of_a_test", controller(tmp_path))
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    with raises(tool.ControllerError, "PD", "Plant2DOF.fmu"), \
            pytest.warns(UserWarning):
        tool.run(trial(tmp_path), controller=module.PD, fmus=old)


def test_a_class_is_of_its_process() -> None:
    """Where it would run in another one, a sentence says so."""
    class PD:
        pass

    with raises(tool.ControllerError, "PD", "process"):
        pickle.dumps(PythonClass(PD))
