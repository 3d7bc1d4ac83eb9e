"""The C in the FMUs: strict compilers have nothing to say, and no instance shares anything with another."""

import re
import subprocess
from pathlib import Path

import pytest
from native_builds import FMI_HEADERS, STRICT, require_command, unpacked_sources

from maglev.descriptions.own_fmus import DEFINITIONS, definition
from maglev.descriptions.registry import known_stages
from maglev.fmi.native_build import SHELLS
from maglev.language.blocks import block_text

# Sections; constant tables of addresses are in .data.rel.ro.
WRITABLE = re.compile(r"\.(data|bss|tdata|tbss)(?!\.rel\.ro)")


@pytest.fixture(scope="module")
def compiled_before() -> set[bytes]:
    """Texts of C files of other FMUs: most have the same ones, which differ by their prefix alone."""
    return set()


@pytest.mark.few(5)
@pytest.mark.parametrize("name", DEFINITIONS)
def test_sources_alone_compile_without_a_warning_and_without_global_variables(
        native_fmus: Path, tmp_path: Path, compiled_before: set[bytes], name: str) -> None:
    """That they are complete is a test of what is in the FMU: tests/maglev/fmi/test_native_description.py."""
    sources = unpacked_sources(native_fmus / f"{name}.fmu", tmp_path)
    files = sorted(path.name for path in sources.glob("*.c") if path.read_bytes() not in compiled_before)
    compiled_before.update((sources / file).read_bytes() for file in files)
    assert "model.c" in files
    done = subprocess.run([require_command("gcc"), *STRICT, *FMI_HEADERS, "-pedantic", "-fPIC", "-c",
                           *files], cwd=sources, capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr[-3000:]
    objects = sorted(path.name for path in sources.glob("*.o"))
    assert len(objects) == len(files)
    listing = subprocess.run([require_command("objdump"), "-w", "-h", *objects], cwd=sources, check=True,
                             capture_output=True, text=True).stdout
    sections = [(row[1], int(row[2], 16)) for row in map(str.split, listing.splitlines()) if row and row[0].isdigit()]
    assert any(section.startswith(".data.rel.ro") and size for section, size in sections), "the table of variables"
    assert [section for section, size in sections if WRITABLE.match(section) and size] == []


def test_our_own_files_compile_without_exceptions(native_fmus: Path, tmp_path: Path) -> None:
    """What people have written: also nothing set but unused, nothing shadowed."""
    sources = unpacked_sources(native_fmus / "Plant3DOF.fmu", tmp_path)
    files = [sources / name for name in (*SHELLS[2].layer, "model.c") if name.endswith(".c")]
    done = subprocess.run([require_command("gcc"), *STRICT, *FMI_HEADERS, "-pedantic", "-Wshadow",
                           "-Wstrict-prototypes", "-Wwrite-strings", "-Wformat=2", "-Wno-format-nonliteral",
                           "-fsyntax-only", *files], capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr[-3000:]


@pytest.mark.parametrize("standard", ["-std=c11", "-std=gnu17"])
def test_newer_standards(native_fmus: Path, tmp_path: Path, standard: str) -> None:
    sources = unpacked_sources(native_fmus / "ScheduledRegulator3DOF.fmu", tmp_path)
    unit = "".join(f'#include "{path.name}"\n' for path in sorted(sources.glob("*.c")))
    done = subprocess.run([require_command("gcc"), *STRICT, *FMI_HEADERS, standard, "-fsyntax-only", "-I",
                           sources, "-xc", "-"], input=unit, capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr[-3000:]


@pytest.mark.parametrize("name", [name for name in known_stages().definitions()
                                  if name.startswith(("ClosedLoop", "Estimator", "Measurement", "Commutation"))])
def test_blocks_call_no_mathematical_library(name: str) -> None:
    """What a processor does rounds everywhere alike; what a library does need not."""
    of = definition(name)
    assert block_text(of.new_block(), of.continuous is not None).library <= {"fabs", "sqrt", "isfinite"}
