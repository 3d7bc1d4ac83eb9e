"""Blocks as C for a microcontroller: strict, without a library, with the bits of the Python that they come from."""

import ctypes
import math
import random
import re
import shutil
import struct
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from facts import raises
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from native_builds import STRICT, built_once, require_command, require_native_tools

from maglev.descriptions.own_fmus import definition
from maglev.files.packages import IN_FMUS
from maglev.fmi.definition import Variable
from maglev.fmi.freestanding import REFUSED_VALUE, freestanding, member, ports_of, template
from maglev.language.errors import ExportError

NAMES = ("Regulator2DOF", "ScheduledRegulator3DOF", "PID3DOF", "LinearRegulator5DOF", "Estimator2DOF",
         "Measurement2DOF")
EXACT = ("-O2", "-ffreestanding", "-ffp-contract=off", "-fno-math-errno")


@pytest.fixture(scope="module")
def written(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with a folder of C for each of the blocks."""
    require_native_tools()

    def make(folder: Path) -> None:
        chosen = [definition(name) for name in NAMES]
        for each in chosen:
            for file, text in freestanding(each, IN_FMUS, "Tests").items():
                place = folder / each.name / file
                place.parent.mkdir(parents=True, exist_ok=True)
                place.write_text(text, encoding="utf-8")

    return built_once(tmp_path_factory, "freestanding", make)


def compiled(source: Path, output: Path, *flags: str) -> Path:
    """What gcc makes of a file, and has nothing to say about."""
    done = subprocess.run([require_command("gcc"), *STRICT, "-pedantic", *EXACT, *flags, source, "-o", output],
                          capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr[-3000:]
    return output


@pytest.mark.few(2)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("arithmetic", ["hardware", "portable"])
def test_it_asks_for_nothing(written: Path, tmp_path: Path, name: str, arithmetic: str) -> None:
    """Three functions are seen, and no other is wanted; nothing is kept outside of what a program gives."""
    flags = ["-c"] + ["-DPORTABLE_ARITHMETIC"] * (arithmetic == "portable")
    made = compiled(written / name / f"{name}.c", tmp_path / "it.o", *flags)
    symbols = subprocess.run([require_command("nm"), made], capture_output=True, text=True, check=True).stdout
    kinds = [line.split()[-2:] for line in symbols.splitlines()]
    assert {symbol for kind, symbol in kinds if kind == "T"} == {f"{name}_init", f"{name}_start", f"{name}_sample"}
    assert {kind for kind, _ in kinds} <= {"T", "t", "r"}
    text = (written / name / f"{name}.c").read_text() + (written / name / f"{name}.h").read_text()
    assert set(re.findall(r"#include <(\S+)>", text)) == {"stdbool.h", "stdint.h"}
    assert max(map(len, (written / name / f"{name}.h").read_text().splitlines())) <= 120


def test_a_header_for_cpp(written: Path, tmp_path: Path) -> None:
    (tmp_path / "it.cpp").write_text('#include "Regulator2DOF.h"\nRegulator2DOF one;\n')
    subprocess.run([require_command("g++"), "-std=c++11", "-Wall", "-Werror", "-I", written / "Regulator2DOF", "-c",
                    tmp_path / "it.cpp", "-o", tmp_path / "it.o"], check=True)


def structure(variables: Iterable[Variable]) -> Any:
    """A structure of ports."""
    fields = [(member(v), ctypes.c_bool if v.boolean else ctypes.c_double) for v in variables]
    return type("Ports", (ctypes.Structure,), {"_fields_": fields})()


@pytest.mark.few(3)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("arithmetic", ["hardware", "portable"])
def test_it_has_the_bits_of_the_block(written: Path, tmp_path: Path, name: str, arithmetic: str) -> None:
    """From random inputs, as a host that knows only the header sees it; a value out of range is no sample."""
    flags = ["-shared", "-fPIC"] + ["-DPORTABLE_ARITHMETIC"] * (arithmetic == "portable")
    library = ctypes.CDLL(str(compiled(written / name / f"{name}.c", tmp_path / "it.so", *flags)))
    described = definition(name)
    block, (_, readable) = described.new_block(), ports_of(described)
    of_inputs = [(k, v) for k, v in enumerate(described.variables) if v.causality == "input"]
    inputs, outputs = structure(v for _, v in of_inputs), structure(readable)
    memory = ctypes.create_string_buffer(b"\xA5" * 2**16, 2**16)   # of any program's
    start, sample = getattr(library, f"{name}_start"), getattr(library, f"{name}_sample")
    getattr(library, f"{name}_init")(memory)
    assert start(memory) == block.start() == 0
    source, step = random.Random(name), block.sample_time
    changed = set()
    for k in range(400):
        for number, v in of_inputs:
            size = {"m": 2e-3, "m/s": 0.05, "rad": 1e-3, "A": 1.0}.get(v.unit, 0.1)
            value = float(described.start_value(v)) + source.uniform(-size, size)
            if k % 50 == 7 and number == of_inputs[k // 50 % len(of_inputs)][0]:
                setattr(inputs, member(v), math.nan if k % 100 == 7 else 1e300)
                assert sample(memory, ctypes.byref(inputs), ctypes.byref(outputs)) == REFUSED_VALUE + number
            setattr(inputs, member(v), value)
            v.write(block, value)
        assert sample(memory, ctypes.byref(inputs), ctypes.byref(outputs)) == block.step(k * step, step) == 0
        for v in readable:
            expected, found = v.read(block), getattr(outputs, member(v))
            assert struct.pack("<d", found) == struct.pack("<d", expected), (k, v.name)
            changed |= {v.name} if k and expected != float(described.start_value(v)) else set()
    assert len(changed) > 1


@pytest.fixture(scope="module")
def portable(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The arithmetic in integers, of processors without a square root."""
    folder = tmp_path_factory.mktemp("portable")
    (folder / "it.c").write_text(f"#include <stdint.h>\n{template('arithmetic.h')}\n"
                                 "double root(double x) { return sqrt(x); }\n"
                                 "double size(double x) { return fabs(x); }\n")
    library = ctypes.CDLL(str(compiled(folder / "it.c", folder / "it.so", "-shared", "-fPIC", "-DPORTABLE_ARITHMETIC")))
    for function in (library.root, library.size):
        function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double]
    return library


@given(st.lists(st.one_of(st.floats(), st.floats(0.0, 4.0), st.floats(0.0, 1e-300), st.integers(0, 2**53).map(float)),
                min_size=20, max_size=20))   # Hypothesis takes longer to begin an example than to draw so many
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@example([0.0, -0.0, 5e-324, 2.2250738585072014e-308, 1.7976931348623157e308, math.inf, math.nextafter(4.0, 0.0),
          math.nextafter(1.0, 0.0)])
def test_portable_arithmetic_has_the_bits_of_the_processor(portable: Any, numbers: list[float]) -> None:
    for x in numbers:
        assert struct.pack("<d", portable.size(x)) == struct.pack("<d", math.fabs(x)) or math.isnan(x)
        root = portable.root(x)
        if x < 0.0 or math.isnan(x):
            assert math.isnan(root)
        else:
            assert struct.pack("<d", root) == struct.pack("<d", math.sqrt(x)), x


def test_cmake_makes_a_library_and_an_example(written: Path, tmp_path: Path) -> None:
    cmake = shutil.which("cmake") or shutil.which("cmake", path=str(Path(sys.executable).parent))
    if cmake is None:
        pytest.skip("cmake is not installed")
    name = "Regulator2DOF"
    (tmp_path / "board.c").write_text(f"""
#include "board.h"
#include <math.h>
#include <stdio.h>
static int left = 6;
void board_begin(struct {name} *controller) {{ controller->block.axes[0].k1 *= 1.5; }}
bool board_read(struct {name}_inputs *inputs)
{{
    *inputs = (struct {name}_inputs){{.v_reference = 0.02, .v_measured = left > 1 ? 0.0201 : NAN}};
    return left-- > 0;
}}
void board_write(const struct {name}_outputs *outputs) {{ printf("%.17g\\n", outputs->motor_i_d_cmd); }}
void board_end(int32_t status) {{ printf("%d\\n", (int)status); }}
""")
    commands: tuple[list[str | Path], ...] = (["-S", written / name, "-B", tmp_path / "made",
                                               "-DBOARD=board.c"],   # where cmake is called
                                              ["--build", tmp_path / "made"])
    for command in commands:
        done = subprocess.run([cmake, *command], capture_output=True, text=True, cwd=tmp_path)
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    said = subprocess.run([tmp_path / "made" / "example"], capture_output=True, text=True).stdout.split()
    block = definition(name).new_block()
    block.axes[0].k1 *= 1.5
    block.axes[0].reference, block.axes[0].measured = 0.02, 0.0201
    assert block.start() == 0
    expected = []
    for k in range(5):
        assert block.step(k * block.sample_time, block.sample_time) == 0
        expected.append(block.motors[0].i_d_cmd)
    # The sixth is refused for its measurement, the third variable; no currents are written for it.
    assert [float(each) for each in said[:-1]] == expected and said[-1] == "1002"


@pytest.mark.parametrize(("change", "facts"), [
    ({"sampled": False}, ["Regulator2DOF", "sample_time"]),
    ({"variables": (*definition("Regulator2DOF").variables,
                    replace(definition("Regulator2DOF").variables[0], name="v_reference", path="v.reference"))},
     ["v.reference", "v_reference"])])
def test_what_cannot_be_written(change: dict[str, Any], facts: list[str]) -> None:
    with raises(ExportError, *facts):
        freestanding(replace(definition("Regulator2DOF"), **change), IN_FMUS, "Tests")
