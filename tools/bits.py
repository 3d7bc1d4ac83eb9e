"""Run the same three runs on every processor, C library, Python and browser here; digests into docs/accuracy.md.

    python tools/bits.py          # writes the table of the page
    python tools/bits.py --check  # compares with it what is here

Stages under control for 2 s with all effects on: see EFFECTS and WAVES. A digest is of all outputs at all samples.
"""

import argparse
import atexit
import json
import os
import platform
import re
import shutil
import subprocess
import sys
from base64 import b64encode
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from maglev.analysis.target import FLAGS as CORTEX_M7
from maglev.analysis.target import OPTIONS, PROGRAM
from maglev.descriptions.own_fmus import definition
from maglev.descriptions.registry import known_stages
from maglev.files.marked import markdown_table, write_part
from maglev.files.packages import IN_FMUS
from maglev.files.scratch import scratch
from maglev.fmi.block_code import BLOCK, block_code, c_path
from maglev.fmi.compiler import FLAGS, UNIT, WEBASSEMBLY, Platform, library
from maglev.fmi.definition import FmuDefinition
from maglev.fmi.freestanding import template
from maglev.language.c_text import c_literal

ROOT = Path(__file__).parents[1]
HOSTS = ROOT / "tools" / "bits_hosts"
PAGE = ROOT / "docs" / "accuracy.md"
NOT_HERE = "not run here"

NAMES = ("ClosedLoop2DOF", "ClosedLoop3DOF", "ClosedLoop5DOF")
STOP_TIME = 2.0   # s

# Parameters by the pattern of their names, next to what the stages have by default: friction, bias, modulation of the
# attraction, lag and continuous rating of the amplifiers, encoders.
EFFECTS = {
    "plant.magnet_rise": 15.0, "plant.*.winding.thermal_resistance": 2.0, "plant.*.winding.thermal_time": 5.0,
    "plant.*.amplifier.thermal_time": 0.2, "plant.[!rp]*.ripple.amplitude": 0.1, "plant.?.mode.frequency": 120.0,
    "plant.?.mode.encoder_share": 0.1, "plant.?.roughness.rms": 0.05,
    "controller.?.friction_compensation": 0.02, "controller.antiwindup": True}


class Wave(NamedTuple):
    """A sinusoid on an input: about its start value, amplitude, frequency (Hz), phase (turns)."""

    middle: float
    amplitude: float
    frequency: float
    phase: float


# So that the continuous rating and the voltage are limits now and then, and the stage is not lost.
LIMITS = {"2DOF": (0.75, 8.0), "3DOF": (1.5, 12.0), "5DOF": (2.2, 27.0)}   # A, V

# Amplitude and frequency (Hz) by the pattern of an input's name; their phases are spread, rates are the derivatives.
WAVES = {"[vy].reference": (0.5e-3, 1.3), "[hxz].reference": (4e-3, 0.7), "?*[lh].reference": (2e-3, 0.9),
         "?.floor_acceleration": (0.2, 5.0), "[hxz].force": (1.5, 2.1), "?*[lh].torque": (0.05, 1.7)}


@dataclass(frozen=True)
class Run:
    """One closed loop: its start values, inputs over time and recorded numbers, by attribute path of its block."""

    of: FmuDefinition
    start: Mapping[str, float | bool]
    waves: Mapping[str, Wave]
    numbers: tuple[str, ...]
    step: float
    steps: int

    def plan(self) -> dict[str, Any]:
        """Return the plan for a host in Python, without the modules of an FMU."""
        return {"definition": known_stages().definitions()[self.of.name].text(), "start": self.start,
                "waves": self.waves, "numbers": self.numbers, "step": self.step, "steps": self.steps}

    def code(self) -> str:
        """Return the same plan as a function in C."""
        start = [f"loop.{c_path(place)} = {c_literal(value)};" for place, value in self.start.items()]
        waves = [f"loop.{c_path(place)} = {c_literal(w.middle)} + {c_literal(w.amplitude)} * "
                 f"sine_cosine__sine_of_turns({c_literal(w.frequency)} * t + {c_literal(w.phase)});"
                 for place, w in self.waves.items()]
        taken = [f"digest = taken(digest, loop.{c_path(place)});" for place in self.numbers]
        return "\n".join([
            '#include "block.h"', "",
            "static uint64_t run(void)", "{", "    Block loop = INITIAL;",
            *indented_lines(1, start), "    if (start_block(&loop)) {", "        return 0;", "    }",
            "    uint64_t digest = EMPTY_DIGEST;", f"    for (int k = 0; k < {self.steps}; ++k) {{",
            f"        const double t = k * {c_literal(self.step)};", *indented_lines(2, waves),
            f"        if (step_block(&loop, t, {c_literal(self.step)})) {{", "            return 0;", "        }",
            *indented_lines(2, taken), "    }", "    return digest;", "}", ""])


def indented_lines(depth: int, lines: Iterable[str]) -> list[str]:
    return [4 * depth * " " + line for line in lines]


def loop_run(name: str) -> Run:
    """The run of a closed loop; ValueError if an effect or a wave is of no variable of it."""
    of = definition(name)
    block = of.new_block()
    start: dict[str, float | bool] = {}
    continuous, voltage = LIMITS[name.removeprefix("ClosedLoop")]
    for pattern, value in {**EFFECTS, "plant.*.amplifier.continuous": continuous, "plant.bus_voltage": voltage}.items():
        places = [v.place for v in of.variables if v.causality == "parameter" and fnmatch(v.name, pattern)]
        if not places:
            raise ValueError(f"{name}: no parameter is like {pattern}")
        start |= dict.fromkeys(places, value)
    waves: dict[str, Wave] = {}
    for v in of.variables:
        for pattern, (amplitude, frequency) in WAVES.items():
            if v.causality == "input" and fnmatch(v.name, pattern):
                phase = len(waves) / 16
                waves[v.place] = Wave(v.read(block), amplitude, frequency, phase)
                if v.name.endswith(".reference"):
                    rate = 6.283185307179586 * frequency * amplitude
                    waves[f"{v.place}_rate"] = Wave(0.0, rate, frequency, phase + 0.25)
    step = float(of.start_value(next(v for v in of.variables if v.name.endswith("sample_time"))))
    return Run(of, start, waves, tuple(v.place for v in of.variables if v.causality == "output"), step,
               round(STOP_TIME / step))


@cache
def runs() -> tuple[Run, ...]:
    return tuple(map(loop_run, NAMES))


def sources(run: Run) -> dict[str, str]:
    return {BLOCK: block_code(run.of, IN_FMUS).text, "run.h": run.code(),
            "host.c": (HOSTS / "host.c").read_text(encoding="utf-8")}


class Absent(Exception):
    """Raised for a program that an environment needs and this machine lacks."""


def program_path(*names: str) -> str:
    """Path of the first of some programs that is there."""
    for name in names:
        if path := shutil.which(name):
            return path
    raise Absent(f"no {names[0]}")


def printed_digest(*arguments: str | Path, text: str = "", environment: Mapping[str, str] | None = None) -> str:
    """The digest that a program prints. RuntimeError if it prints anything else."""
    done = subprocess.run(arguments, input=text, capture_output=True, text=True,
                          env={**os.environ, **(environment or {})})
    if done.returncode != 0 or not re.fullmatch("[0-9a-f]{16}", done.stdout.strip()):
        raise RuntimeError(f"{arguments[0]}: {(done.stdout + done.stderr)[-500:]!r}, expected a digest")
    return done.stdout.strip()


def python(minor: int, run: Run) -> str:
    """The block on a version of Python; the one that runs this, if it is that."""
    own = sys.executable if sys.version_info[1] == minor else None
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"), "versions")
    # pyenv's own program first: the one on the path may be a shim that refuses.
    path = own or next(map(str, pyenv.glob(f"3.{minor}.*/bin/python")), None) or shutil.which(f"python3.{minor}")
    if path is None:
        raise Absent(f"no Python 3.{minor}")
    return printed_digest(path, "-IB", HOSTS / "host.py", ROOT, text=json.dumps(run.plan()))


def by_gcc(run: Run) -> str:
    """The C library and the compiler of this system."""
    compiler = program_path("gcc")
    with scratch() as folder:
        for name, text in sources(run).items():
            (folder / name).write_text(text, encoding="utf-8")
        unit = UNIT.format("bits")
        units = "".join(f'#include "{name}"\n' for name in sorted(sources(run)) if name.endswith(".c"))
        (folder / unit).write_text(units, encoding="utf-8")
        subprocess.run([compiler, *FLAGS, "-o", folder / "bits", folder / unit], check=True)
        return printed_digest(folder / "bits")


def by_zig(target: str, flags: tuple[str, ...], emulator: str, run: Run,
           further: Mapping[str, str] | None = None) -> str:
    """Return the digest of a run that zig compiles for a target, with further files, and that an emulator may run."""
    before = [*map(program_path, emulator.split()[:1]), *emulator.split()[1:]]
    ending = ".exe" if "windows" in target else ""
    with scratch() as folder:
        program = folder / f"bits{ending}"
        program.write_bytes(library({**sources(run), **(further or {})}, "bits", Platform((target,), ending, flags)))
        program.chmod(0o700)
        return printed_digest(*before, program, environment={
            "WINEDEBUG": "-all", "WINEPREFIX": wine_prefix(), "DISPLAY": ""} if emulator == "wine" else {})


def on_cortex_m7(run: Run) -> str:
    """A microcontroller that QEMU emulates, without an operating system or a library."""
    files = {"math.h": template("arithmetic.h"), "stdlib.h": "", "board.ld": template("qemu/mps2_an500.ld"),
             "bare.h": (HOSTS / "bare.h").read_text(encoding="utf-8")}
    return by_zig("thumb-freestanding-eabihf", (*CORTEX_M7, "-T", "board.ld"), " ".join([PROGRAM, *OPTIONS]), run,
                  files)


@cache
def wine_prefix() -> str:
    """Folder of Wine's registry and drives, which it needs a minute to fill; it goes with this process."""
    kept = TemporaryDirectory(prefix="bits_wine_")
    atexit.register(kept.cleanup)
    return kept.name


@cache
def webassembly(name: str) -> bytes:
    return library(sources(next(run for run in runs() if run.of.name == name)), "bits", WEBASSEMBLY)


def node(run: Run) -> str:
    program = program_path("node")
    with scratch() as folder:
        (folder / "bits.wasm").write_bytes(webassembly(run.of.name))
        return printed_digest(program, HOSTS / "host.mjs", folder / "bits.wasm")


def in_wasmtime(run: Run) -> str:
    try:
        from wasmtime import Engine, Instance, Module, Store
    except ImportError:
        raise Absent("no wasmtime") from None
    engine = Engine()
    store = Store(engine)
    functions: Any = Instance(store, Module(engine, webassembly(run.of.name)), []).exports(store)
    functions["_initialize"](store)
    return f"{functions['digest_of_run'](store) & (1 << 64) - 1:016x}"


def chromium(run: Run) -> str:
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        raise Absent("no playwright") from None
    path = program_path("chromium", "chromium-browser", "google-chrome")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        digest = browser.new_page().evaluate("""async (text) => {
            const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
            const { instance } = await WebAssembly.instantiate(bytes, {});
            instance.exports._initialize();
            return String(instance.exports.digest_of_run()); }""", b64encode(webassembly(run.of.name)).decode())
        browser.close()
    return f"{int(digest) & (1 << 64) - 1:016x}"


class Environment(NamedTuple):
    """A host of the runs: its name, its compiler and program, and its function for the digest of a run."""

    name: str
    by: str
    digest: Callable[[Run], str]

    def digests(self) -> tuple[str, ...] | str:
        """Digests of the runs there, or what is missing here."""
        try:
            return tuple(map(self.digest, runs()))
        except Absent as absent:
            return str(absent)


PROCESSORS = {"x86_64": "x86-64", "aarch64": "AArch64"}
OWN = "aarch64" if platform.machine().lower() in ("aarch64", "arm64") else "x86_64"
STATIC = ("-static",)

# What the gate can afford: no emulator, no browser, one Python.
QUICK = (
    Environment(f"Python 3.{sys.version_info[1]}", "CPython", partial(python, sys.version_info[1])),
    Environment(f"C, {PROCESSORS[OWN]}, the system's C library", "gcc", by_gcc),
    Environment(f"C, {PROCESSORS[OWN]}, glibc", "zig", partial(by_zig, f"{OWN}-linux-gnu.2.17", (), "")),
    Environment("WebAssembly", "zig, Node", node),
    Environment("WebAssembly", "zig, wasmtime", in_wasmtime))
THOROUGH = (
    *(Environment(f"Python 3.{minor}", "CPython", partial(python, minor))
      for minor in (11, 12, 13, 14) if minor != sys.version_info[1]),
    Environment(f"C, {PROCESSORS[OWN]}, musl", "zig", partial(by_zig, f"{OWN}-linux-musl", STATIC, "")),
    Environment("C, x86-64-v3, which has fused multiply-add", "zig, qemu-x86_64",
                partial(by_zig, "x86_64-linux-musl", (*STATIC, "-mcpu=x86_64_v3"), "qemu-x86_64")),
    *(Environment(f"C, {name}", f"zig, {emulator}", partial(by_zig, target, STATIC, emulator))
      for name, target, emulator in (
          ("AArch64, musl", "aarch64-linux-musl", "qemu-aarch64"),
          ("RISC-V 64, musl", "riscv64-linux-musl", "qemu-riscv64"),
          ("32-bit ARM, musl", "arm-linux-musleabihf", "qemu-arm"),
          ("32-bit x86, musl", "x86-linux-musl", "qemu-i386"),
          ("IBM z, highest byte first, musl", "s390x-linux-musl", "qemu-s390x"))),
    Environment("C, Cortex-M7, no library", "zig, qemu-system-arm", on_cortex_m7),
    Environment("C, x86-64 Windows", "zig, Wine", partial(by_zig, "x86_64-windows-gnu", (), "wine")),
    Environment("WebAssembly", "zig, Chromium", chromium))


def results_table(results: Mapping[Environment, tuple[str, ...] | str]) -> str:
    cells = {environment: [f"{NOT_HERE}: {result}", *[""] * (len(NAMES) - 1)] if isinstance(result, str) else
             [f"`{digest}`" for digest in result] for environment, result in results.items()}
    stages = [name.removeprefix("ClosedLoop").replace("DOF", "-DOF") for name in NAMES]
    return markdown_table(("where", "by", *stages), ((environment.name, environment.by, *row)
                                                     for environment, row in cells.items()))


def of_page() -> set[tuple[str, ...]]:
    """Digests in the page: one of each run, where all agree."""
    text = PAGE.read_text(encoding="utf-8").partition("<!-- bits: ")[2].partition("<!-- end of bits -->")[0]
    rows = [tuple(re.findall("`([0-9a-f]{16})`", line)) for line in text.splitlines()]
    return {row for row in rows if row}


def main() -> None:
    """Run everything that is here; the exit code is 1 where two environments differ."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare with the page instead of writing it")
    arguments = parser.parse_args()
    results = {}
    for environment in QUICK + THOROUGH:
        results[environment] = environment.digests()
        print(f"{environment.name} ({environment.by}): {results[environment]}", flush=True)
    seen = {result for result in results.values() if not isinstance(result, str)}
    if arguments.check:
        seen |= of_page()
    else:
        write_part(PAGE, "bits", results_table(results))
    if len(seen) != 1 or any("0" * 16 in digest for digest in seen):
        sys.exit(f"not the same bits: {seen}")


if __name__ == "__main__":
    main()
