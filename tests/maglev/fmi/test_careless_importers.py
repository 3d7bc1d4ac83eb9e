"""What importers do seldom, or should not do at all: each in a process of its own, which it might end."""

import re
import signal
import subprocess
import sys
from pathlib import Path
from urllib.parse import quote
from zipfile import ZipFile

import pytest

# An importer as FMI's functions see it, which are asked for a status and do not raise.
IMPORTER = """
import ctypes, sys
from fmpy import read_model_description
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.logging import addLoggerProxy
folder = sys.argv[1]
description = read_model_description(folder)
said = []
def log(environment, name, status, category, message):
    said.append(message.decode())
callbacks = fmi2CallbackFunctions(logger=fmi2CallbackLoggerTYPE(log))
addLoggerProxy(ctypes.byref(callbacks))   # which puts what is said into its format
fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder, instanceName="one",
                modelIdentifier=description.coSimulation.modelIdentifier)
call = fmu.dll
for name in ("fmi2GetFMUstate", "fmi2FreeFMUstate", "fmi2SerializeFMUstate", "fmi2Terminate", "fmi2DoStep"):
    call[name].restype = ctypes.c_int
def instantiate(name=b"one", guid=description.guid.encode(), location="file://" + folder + "/resources"):
    return fmu.fmi2Instantiate(name, 1, guid, location.encode(), ctypes.byref(callbacks), 0, 1)
def started():
    fmu.component = instantiate()
    fmu.setupExperiment()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return ctypes.c_void_p(fmu.component)
"""


def run(fmu: Path, folder: Path, body: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    if not folder.exists():
        with ZipFile(fmu) as archive:
            archive.extractall(folder)
    return subprocess.run([sys.executable, "-c", IMPORTER + body, str(folder), *arguments], capture_output=True,
                          text=True)


def printed(fmu: Path, folder: Path, body: str, *arguments: str) -> str:
    done = run(fmu, folder, body, *arguments)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout.strip()


def test_freed_state_leaves_no_handle(either_kind: Path, tmp_path: Path) -> None:
    """FMI 2.0.5, section 2.1.8: a null pointer is left, and freeing that does nothing."""
    assert printed(either_kind / "Plant2DOF.fmu", tmp_path / "fmu", """
component, state = started(), ctypes.c_void_p()
for _ in range(2):
    assert call["fmi2GetFMUstate"](component, ctypes.byref(state)) == 0 and state.value
    for _ in range(2):
        print(call["fmi2FreeFMUstate"](component, ctypes.byref(state)), state.value)
fmu.fmi2FreeInstance(component)
""").splitlines() == ["0 None"] * 4


def test_a_state_saved_over_another_leaves_no_memory(either_kind: Path, tmp_path: Path) -> None:
    """A master that goes back and forth with one state; the handle of the state before is given (section 2.1.8)."""
    grown = printed(either_kind / "Plant2DOF.fmu", tmp_path / "fmu", """
import os
component, state = started(), ctypes.c_void_p()
def rollback(count):
    for _ in range(count):
        assert call["fmi2GetFMUstate"](component, ctypes.byref(state)) == 0
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
before = rollback(500)
print(rollback(3000) - before)
fmu.setFMUState(state)
assert call["fmi2DoStep"](component, ctypes.c_double(0.0), ctypes.c_double(5e-4), 1) == 0
""")
    assert int(grown) < 500_000, "bytes; 3000 states that are left take megabytes"


def test_serialized_state_that_finds_no_room(either_kind: Path, tmp_path: Path) -> None:
    """Refused, and no byte outside its room is written; the instance can be freed."""
    lines = printed(either_kind / "Plant2DOF.fmu", tmp_path / "fmu", """
component, state = started(), ctypes.c_void_p()
fmu.fmi2GetFMUstate(component, ctypes.byref(state))
size = len(fmu.serializeFMUstate(state))
for room in (size + 5, size, size - 1, size // 2, 0):
    place = ctypes.create_string_buffer(b"x" * (size + 10))
    status = call["fmi2SerializeFMUstate"](component, state, place, ctypes.c_size_t(room))
    print(room - size if room >= size else "less", status > 2, set(place.raw[size:size + 10]) == {ord("x")})
print(any("SerializeFMUstate" in text or "room for a serialized state" in text for text in said))
fmu.fmi2FreeInstance(component)
import gc
gc.collect()
assert started().value
""").splitlines()
    assert lines == ["5 False True", "0 False True", *["less True True"] * 3, "True"]


def test_terminated_twice(either_kind: Path, tmp_path: Path) -> None:
    assert printed(either_kind / "Plant2DOF.fmu", tmp_path / "fmu", """
component = started()
assert call["fmi2Terminate"](component) == 0
assert call["fmi2Terminate"](component) > 2
print(said[-1])
""").removesuffix("')").endswith("fmi2Terminate after fmi2Terminate, expected after the initialization")


def test_guid_of_another_fmu(native_fmus: Path, tmp_path: Path) -> None:
    lines = printed(native_fmus / "Plant2DOF.fmu", tmp_path / "fmu", """
print(instantiate(guid=b"{that of another FMU}"), said[-1])
""")
    assert lines.startswith("None GUID = {that of another FMU}, expected {")


def test_model_description_of_another_fmu(either_kind: Path, tmp_path: Path) -> None:
    """The Python kind does not see the GUID that it is given, but the file that importers have it from."""
    with ZipFile(either_kind / "Plant2DOF.fmu") as archive:
        archive.extractall(tmp_path / "fmu")
    path = tmp_path / "fmu" / "modelDescription.xml"
    path.write_text(re.sub(r'guid="{(.)', r'guid="{0\1', path.read_text(encoding="utf-8")), encoding="utf-8")
    line = printed(either_kind / "Plant2DOF.fmu", tmp_path / "fmu", "print(instantiate(), said[-1].splitlines()[-1])")
    assert line.startswith("None ") and "GUID = {0" in line
    assert "model description and " in line and " are not of the same FMU" in line


def test_instance_without_a_name(either_kind: Path, tmp_path: Path) -> None:
    line = printed(either_kind / "Plant2DOF.fmu", tmp_path / "fmu", 'print(instantiate(name=b""), said[-1])')
    assert line.startswith("None ") and "instance name = '', expected one" in line


@pytest.mark.parametrize("form", ["file://{}/resources", "file://localhost{}/resources", "file:/nowhere/{}"])
def test_location_that_the_python_kind_does_not_understand(fmus: Path, tmp_path: Path, form: str) -> None:
    """An error that is said, and another instance after it."""
    folder = tmp_path / "Müller"
    location = form.format(quote(str(folder)))
    line, again = printed(fmus / "Plant2DOF.fmu", folder, f"""
print(instantiate(location={location!r}), repr(said[-1]))
print(started().value is not None)
""").splitlines()
    assert line.startswith("None ") and "[ctor] findClass" in line
    assert again == "True"


def test_null_pointers(native_fmus: Path, tmp_path: Path) -> None:
    lines = printed(native_fmus / "Plant2DOF.fmu", tmp_path / "fmu", """
function = call["fmi2Instantiate"]
for name, functions in ((None, ctypes.byref(callbacks)), (b"one", None)):
    print(function(name, 1, description.guid.encode(), None, functions, 0, 1))
print(call["fmi2Terminate"](None), call["fmi2FreeFMUstate"](None, None))
print(said)
""").splitlines()
    assert lines == ["0", "0", "3 3", "[\"instance name = '', expected one\"]"]


def test_null_pointer_that_ends_the_process(fmus: Path, tmp_path: Path) -> None:
    """In pythonfmu's library, before anything of this project is called."""
    done = run(fmus / "Plant2DOF.fmu", tmp_path / "fmu", "instantiate(name=None)")
    assert done.returncode == -signal.SIGABRT
