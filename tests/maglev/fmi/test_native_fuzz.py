"""The C layer under sanitizers and valgrind: random FMI calls in random order (`c/fuzz.c`)."""

import random
import struct
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from native_builds import HERE, built_once, compiled, require_command, unpacked_sources

FUZZED = ("Plant3DOF", "ScheduledRegulator3DOF", "PID2DOF")
SANITIZERS = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all", "-O1", "-g")


@pytest.fixture(scope="session")
def sanitized(native_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Function that compiles the driver for an FMU, with sanitizers, by its name."""
    def driver(name: str) -> Path:
        def make(folder: Path) -> None:
            sources = unpacked_sources(native_fmus / f"{name}.fmu", folder / "sources")
            compiled(sources, folder / name, *SANITIZERS, extra=(HERE / "fuzz.c",))

        return built_once(tmp_path_factory, f"native_fuzz_{name}", make) / name

    return driver


def carry_out(command: Sequence[str | Path], programs: Sequence[bytes], folder: Path) -> str:
    """What the driver says of programs; fails the test if it, a sanitizer or valgrind objects."""
    path = folder / "programs"
    path.write_bytes(b"".join(struct.pack("<H", len(each)) + each for each in programs))
    done = subprocess.run([*command, path], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, f"{done.stdout[-500:]}{done.stderr[-3000:]}"
    return done.stdout


def random_programs(count: int, seed: int) -> list[bytes]:
    """Programs of all lengths up to a few hundred calls."""
    source = random.Random(seed)
    return [source.randbytes(source.randrange(1, 600)) for _ in range(count)]


@pytest.mark.thorough
@pytest.mark.parametrize("name", [pytest.param(FUZZED[0], marks=pytest.mark.thorough), *FUZZED[1:]])
def test_many_random_programs(sanitized: Callable[[str], Path], tmp_path: Path, name: str) -> None:
    said = carry_out([sanitized(name)], random_programs(3000, 1), tmp_path)
    count, refusals = (int(word) for word in said.split() if word.isdigit())
    assert count == 3000 and refusals > 10000


@pytest.mark.thorough
def test_many_random_programs_of_fmi_3(fmi3_fmus: Path, tmp_path: Path) -> None:
    sources = unpacked_sources(fmi3_fmus / "Regulator3DOF.fmu", tmp_path)
    tool = compiled(sources, tmp_path / "fuzz", *SANITIZERS, "-DFMI3", extra=(HERE / "fuzz.c",))
    said = carry_out([tool], random_programs(3000, 1), tmp_path)
    count, refusals = (int(word) for word in said.split() if word.isdigit())
    assert count == 3000 and refusals > 10000


@pytest.mark.thorough
@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("kind", ["fmi3_fmus", "clocked_fmus"])
def test_many_random_programs_of_event_mode(request: pytest.FixtureRequest, tmp_path: Path, kind: str) -> None:
    """`c/fuzz_events.c`: any order of calls; no sample is passed over."""
    sources = unpacked_sources(request.getfixturevalue(kind) / "Regulator3DOF.fmu", tmp_path)
    tool = compiled(sources, tmp_path / "fuzz", *SANITIZERS, "-DFMI3", "-Wno-unused-function",
                    extra=(HERE / "fuzz_events.c",))
    said = carry_out([tool], random_programs(500, 4), tmp_path)
    count, refusals = (int(word) for word in said.split() if word.isdigit())
    assert count == 500 and refusals > 10000


@pytest.mark.thorough
@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("kind", ["fmi3_fmus", "clocked_fmus"])
def test_outputs_are_read_before_inputs_are_set(request: pytest.FixtureRequest, tmp_path: Path, kind: str) -> None:
    """`c/feedback.c`: as in a feedback loop; every output has the bits that it has without a question before."""
    sources = unpacked_sources(request.getfixturevalue(kind) / "Regulator3DOF.fmu", tmp_path)
    tool = compiled(sources, tmp_path / "feedback", *SANITIZERS, "-DFMI3", "-Wno-unused-function",
                    extra=(HERE / "feedback.c",))
    done = subprocess.run([tool], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (0, "400 samples\n"), done.stderr[-3000:]


@pytest.mark.thorough
@pytest.mark.parametrize("version", [pytest.param(2, marks=pytest.mark.thorough), 3])
def test_many_random_programs_of_model_exchange(native_fmus: Path, fmi3_fmus: Path, tmp_path: Path,
                                                version: int) -> None:
    """`c/fuzz_exchange.c`: any order of calls; what it asks for is finite where the states are in reach."""
    sources = unpacked_sources((fmi3_fmus if version == 3 else native_fmus) / "Plant3DOF.fmu", tmp_path)
    tool = compiled(sources, tmp_path / "fuzz", *SANITIZERS, *(["-DFMI3"] if version == 3 else []),
                    extra=(HERE / "fuzz_exchange.c",))
    said = carry_out([tool], random_programs(2000, 3), tmp_path)
    count, refusals = (int(word) for word in said.split() if word.isdigit())
    assert count == 2000 and refusals > 10000


@pytest.mark.thorough
@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(programs=st.lists(st.binary(max_size=300), min_size=1, max_size=30))
def test_programs_that_hypothesis_finds(sanitized: Callable[[str], Path], tmp_path: Path,
                                        programs: list[bytes]) -> None:
    carry_out([sanitized("Plant3DOF")], programs, tmp_path)


@pytest.mark.thorough
def test_programs_under_valgrind(native_fmus: Path, tmp_path: Path) -> None:
    """Reads of memory that was never written, which the sanitizers do not see."""
    valgrind = require_command("valgrind")
    sources = unpacked_sources(native_fmus / "Plant2DOF.fmu", tmp_path)
    tool = compiled(sources, tmp_path / "fuzz", "-O1", "-g", extra=(HERE / "fuzz.c",))
    carry_out([valgrind, "--quiet", "--error-exitcode=9", "--leak-check=full", tool], random_programs(60, 2), tmp_path)
