"""Build everything that a version ships, into dist: `make release`, or `python tools/release.py`.

Wheel and source distribution, the FMUs and SSP files of all kinds, the compatibility information that fmi-standard.org
asks for, the documentation site as `make docs` has left it, the commit and tools (provenance.json), and the checksums
of all (SHA256SUMS). The date in them is that of the commit, so that the same commit and the same tools give the same
bytes.

    python tools/release.py --begin 0.2.0    # gives what is under "Unreleased" that version, wherever one is written
    python tools/release.py --without site   # as long as one tries
"""

import argparse
import csv
import gzip
import hashlib
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import zipfile
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from xml.etree.ElementTree import Element, fromstring

ROOT = Path(__file__).parents[1]
SITE = ROOT / "docs" / "_build" / "html"
# In this order: both the compatibility information and the wheel contain FMUs that were built before.
PARTS = ("python", "native", "compatibility", "site", "wheel")
VERSION = re.compile(r"\d+\.\d+\.\d+")
UNRELEASED = "## Unreleased\n"

# Rules of fmi-standard.org for the files of an FMU's compatibility information (CONTRIBUTING.md of its repository).
INTERFACES = {"CoSimulation": "cs", "ModelExchange": "me"}
MOST_COLUMNS, MOST_BYTES = 10, 1_000_000   # of results; of a CSV file
IMPORTANT = ("position", "velocity", "i_d_cmd", "i_q_cmd", "error")   # endings of results, the most important first
FIXED_STEP, SOLVER = """\
A communication step has the inputs of the last row at or before its start. In FMI 3.0 the importer uses no event mode.
RelTol is the tolerance of the results: a fraction of the largest absolute value of a variable, or of its nominal value
(1 if it has none) if that is larger. Booleans are equal.""", """\
Two rows of inputs at the same time are a step, which is an event.
RelTol is the tolerance of the importer's solver. The results come from the fixed steps of co-simulation: the page "FMI
support" of the documentation says how close a solver comes."""

# What has a say in the bytes.
TOOLS = ("setuptools", "pythonfmu", "fmpy", "ziglang", "numpy", "latex2mathml", "sphinx", "myst-nb", "furo")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--begin", metavar="VERSION", help="write this version into the files, and end")
    parser.add_argument("--out", type=Path, default=ROOT / "dist", help="folder, made again (dist)")
    parser.add_argument("--without", action="append", choices=PARTS, default=[], help="leave a part out")
    options = parser.parse_args()
    if options.begin:
        begin(options.begin)
    else:
        release(options.out.absolute(), [part for part in PARTS if part not in options.without])


def project_version() -> str:
    """Version of the project: it stands in pyproject.toml, and everything else follows."""
    project: str = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    return project


def begin(version: str) -> None:
    """Give what is unreleased a version: in pyproject.toml, CITATION.cff and the changelog."""
    if VERSION.fullmatch(version) is None:
        sys.exit(f"release.py: --begin {version}: expected three numbers, such as 0.2.0")
    old = project_version()
    log = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    if f"\n## {version}\n" in log or UNRELEASED not in log:
        sys.exit(f"release.py: CHANGELOG.md: expected {UNRELEASED.strip()!r} and no '## {version}'")
    for name, before, after in (("pyproject.toml", f'version = "{old}"', f'version = "{version}"'),
                                ("CITATION.cff", f"version: {old}", f"version: {version}"),
                                ("CHANGELOG.md", UNRELEASED, f"{UNRELEASED}\n## {version}\n")):
        text = (ROOT / name).read_text(encoding="utf-8")
        if text.count(before) != 1:
            sys.exit(f"release.py: {name}: {text.count(before)} times {before!r}, expected it once")
        (ROOT / name).write_text(text.replace(before, after), encoding="utf-8")
    print(f"{old} -> {version}: look at `git diff`, commit, `make release`, tag v{version}")


def release(out: Path, parts: list[str]) -> None:
    version, commit, date, dirty = project_version(), git("rev-parse", "HEAD"), git("log", "-1", "--format=%ct"), (
        git("status", "--porcelain") != "")
    if installed("maglev-fmus") != version:
        sys.exit(f"release.py: {installed('maglev-fmus')} is installed, expected {version}: `make build` installs it")
    if "site" in parts and not (SITE / "index.html").is_file():
        sys.exit(f"release.py: there is no {SITE.relative_to(ROOT)}, expected the site: `make docs`")
    os.environ["SOURCE_DATE_EPOCH"] = date
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as scratch:
        for part in parts:
            print(f"release.py: {part}", flush=True)
            if part == "wheel":
                distributions(Path(scratch), out, version, int(date))
            else:
                folder = SITE if part == "site" else fmus(Path(scratch) / part, part)
                pack_archive(out / f"maglev-fmus-{version}-{part}.zip", folder)
    provenance = {"project": "maglev-fmus", "version": version, "commit": commit, "dirty": dirty,
                  "date": datetime.fromtimestamp(int(date), UTC).isoformat(), "python": platform.python_version(),
                  "system": f"{platform.system()} {platform.machine()}",
                  "tools": {name: of_tool(name) for name in TOOLS},
                  "left_out": [part for part in PARTS if part not in parts]}
    (out / "provenance.json").write_text(json.dumps(provenance, indent=2) + "\n", encoding="utf-8")
    files = sorted(out.iterdir())
    sums = "".join(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in files)
    (out / "SHA256SUMS").write_text(sums, encoding="utf-8")
    for path in files:
        print(f"{path.name}  {path.stat().st_size / 1e6:.1f} MB")
    if dirty:
        print("release.py: there are changes that are not committed, provenance.json says so")


def git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()


def of_tool(name: str) -> str | None:
    """Version of a tool; None where it is not installed, and so had no say."""
    try:
        return installed(name)
    except PackageNotFoundError:
        return None


def distributions(scratch: Path, out: Path, version: str, date: int) -> None:
    """Source distribution of what git knows and does not ignore; the wheel of what is in that, and of native FMUs.

    With them come the modules of the live page: from the wheel both need no compiler.
    """
    import maglev
    from maglev.descriptions.packaged import PACKAGED_STAGES
    from maglev.pages.live_content import modules_of

    source = scratch / "source"
    for name in git("ls-files", "--cached", "--others", "--exclude-standard", "-z").split("\0"):
        if (ROOT / name).is_file() and not name.startswith("tests/"):   # setuptools would take a few of the tests
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, source / name)
    made = "import setuptools.build_meta as build; build.build_{}({!r})"
    subprocess.run([sys.executable, "-c", made.format("sdist", str(scratch))], cwd=source, check=True,
                   stdout=subprocess.DEVNULL)
    name = f"maglev_fmus-{version}"
    with tarfile.open(scratch / f"{name}.tar.gz") as archive:
        archive.extractall(scratch, filter="data")
    tidied(scratch / f"{name}.tar.gz", out / f"{name}.tar.gz", date)
    if (scratch / "native").is_dir():
        shipped = scratch / name / "maglev" / "shipped"
        shutil.copytree(scratch / "native" / "step_loop", shipped / "step_loop")
        shutil.copytree(scratch / "native" / "native", shipped / "native", ignore=shutil.ignore_patterns("*.ssp"))
        modules = dict.fromkeys(name for stage in PACKAGED_STAGES.values() for name in modules_of(stage))
        maglev.build(modules, fmus=shipped, kind="native", target="wasm")
    subprocess.run([sys.executable, "-c", made.format("wheel", str(out))], cwd=scratch / name, check=True,
                   stdout=subprocess.DEVNULL)


def tidied(given: Path, path: Path, date: int) -> None:
    """Write an archive again without what depends on machine, user and hour, which setuptools puts in."""
    with tarfile.open(given) as archive, path.open("wb") as file, gzip.GzipFile("", "wb", mtime=date, fileobj=file) as \
            packed_file, tarfile.open(fileobj=packed_file, mode="w", format=tarfile.PAX_FORMAT) as written:
        for entry in sorted(archive, key=lambda member: member.name):
            content = archive.extractfile(entry)
            plain = tarfile.TarInfo(entry.name)
            plain.type, plain.size, plain.mtime = entry.type, entry.size, date
            plain.mode = 0o755 if entry.isdir() or entry.mode & 0o100 else 0o644
            written.addfile(plain, BytesIO(content.read()) if content else None)


def fmus(folder: Path, part: str) -> Path:
    """Write the FMUs of a part into a folder; with native ones the loops that step them, for every platform."""
    import maglev
    from maglev.descriptions.own_fmus import DEFINITIONS, definition
    from maglev.scenario.shipped import build_step_loops

    if part == "compatibility":
        return compatibility(folder)
    if part == "python":
        maglev.build(fmus=folder)
        return folder
    for fmi in (2, 3):
        maglev.build(fmus=folder, kind="native", fmi=fmi)
    sampled = [name for name in DEFINITIONS if definition(name).sampled]   # the others have no clock
    maglev.build(sampled, fmus=folder, kind="native", fmi=3, clocked=True)
    build_step_loops(folder / "step_loop")
    return folder


def compatibility(folder: Path) -> Path:
    """Write the compatibility information of the FMUs of the parts next to a folder into it; return the folder.

    Each FMU has the folders VERSION/INTERFACE/KIND/NAME, such as 2.0/me/native/Plant3DOF. FMUs that carry no
    experiments, those with a clock, have no folder.
    """
    for kind in ("python", "native"):
        for path in sorted((folder.parent / kind).rglob("*.fmu")):
            for interface, files in compatibility_files(path).items():
                target = folder / interface / kind / path.stem
                target.mkdir(parents=True)
                shutil.copy(path, target)
                for name, text in files.items():
                    if len(text) > MOST_BYTES:
                        sys.exit(f"release.py: {target / name}: {len(text)} bytes, expected at most {MOST_BYTES}")
                    (target / name).write_text(text, encoding="utf-8", newline="\n")
    return folder


def compatibility_files(path: Path) -> dict[str, dict[str, str]]:
    """Return the texts of the files by interface, such as 2.0/cs, and name; empty if the FMU carries no experiment."""
    from maglev.fmi.experiment_files import FOLDER, SHARE

    name = path.stem
    with zipfile.ZipFile(path) as archive:
        prefix = f"{FOLDER}{name}_validation_"
        carried = {entry.removeprefix(prefix): list(csv.reader(archive.read(entry).decode().splitlines()))
                   for entry in archive.namelist() if entry.startswith(prefix)}
        model = fromstring(archive.read("modelDescription.xml"))
    if not carried:
        return {}
    options = {key: value for key, *_, value in carried["ref.opt"]}
    experiment, made = model.find("DefaultExperiment"), {}
    for interface in filter(lambda element: element.tag in INTERFACES, model):
        solver = interface.tag == "ModelExchange"
        tolerance = experiment.get("tolerance") if solver and experiment is not None else repr(SHARE)
        numbers = {"StartTime": options["StartTime"], "StopTime": options["StopTime"],
                   "StepSize": "0.0" if solver else options["StepSize"], "RelTol": tolerance,
                   "OutputIntervalLength": options["OutputInterval"]}
        files = {f"{name}_ref.csv": csv_text(most_important(carried["ref.csv"])),
                 f"{name}_ref.opt": "".join(f"{key},{value}\n" for key, value in numbers.items()),
                 "Readme.txt": readme(name, model, interface, options)}
        if "in.csv" in carried:
            rows = carried["in.csv"]
            files[f"{name}_in.csv"] = csv_text(with_events(rows) if solver else rows)
        made[f"{model.get('fmiVersion')}/{INTERFACES[interface.tag]}"] = files
    return made


def most_important(rows: Sequence[Sequence[str]]) -> list[list[str]]:
    """Return the table with its first column and at most ten others; `rows` begins with the header."""
    def place(k: int) -> int:
        ending = rows[0][k].rpartition(".")[2]
        return IMPORTANT.index(ending) if ending in IMPORTANT else len(IMPORTANT)

    kept = [0, *sorted(sorted(range(1, len(rows[0])), key=place)[:MOST_COLUMNS])]
    return [[row[k] for k in kept] for row in rows]


def with_events(rows: Sequence[Sequence[str]]) -> list[Sequence[str]]:
    """Return a table of inputs with two rows at the time of each change, which no importer interpolates."""
    header, first, *others = rows
    made = [header, first]
    for before, after in pairwise([first, *others]):
        if after[1:] != before[1:]:
            made += [[after[0], *before[1:]], after]
    return made


def csv_text(rows: Sequence[Sequence[str]]) -> str:
    """Return a table of numbers as CSV; the names in the header stand in double quotes."""
    header, *others = rows
    return "".join(f"{','.join(row)}\n" for row in ([f'"{name}"' for name in header], *others))


def readme(name: str, model: Element, interface: Element, options: Mapping[str, str]) -> str:
    """Return Readme.txt of an interface of an FMU."""
    from maglev.fmi.build import build_date

    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    contact = re.search(r"^authors:\n  - name: (.+)$", citation, re.MULTILINE)
    features = [flag for flag, value in interface.attrib.items() if value == "true"]
    return f"""\
{name}: {model.get("description")}

Interface: FMI {model.get("fmiVersion")}, {"model exchange" if interface.tag == "ModelExchange" else "co-simulation"}
Features to test, by the flags that are true: {", ".join(features)}
Tool: {model.get("generationTool")}
Version: {model.get("version")}
Date: {datetime.fromtimestamp(build_date(), UTC):%Y-%m-%d}
Contact: {contact[1] if contact else ""}
Made by: python tools/release.py, in a clone of the project

{name}_ref.csv has outputs while the inputs step as in {name}_in.csv. The equations of the FMU gave them in Python, at
fixed steps of {options["StepSize"]} s and without FMI, rounded to nine digits.
{SOLVER if interface.tag == "ModelExchange" else FIXED_STEP}
"""


def pack_archive(path: Path, folder: Path) -> None:
    """Write an archive of a folder, sorted, dated by the commit."""
    from maglev.fmi.build import write_archive

    write_archive(path, {file.relative_to(folder).as_posix(): file.read_bytes() for file in folder.rglob("*")
                         if file.is_file() and ".doctrees" not in file.parts and file.name != ".buildinfo"})


if __name__ == "__main__":
    main()
