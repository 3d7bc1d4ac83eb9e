"""Change one line of the blocks at a time, and see whether `maglev check` notices.

    python tools/mutants.py                  # every mutation of mutants.toml
    python tools/mutants.py 3 17 amplifier   # those numbers, and those whose group, file or text contains a word

Each mutation is made in a copy of the packages, the FMUs that it affects are built natively for this machine, and the
runs of its group are checked against the committed baselines until one deviates. What only stages of users have, such
as motors that are not alike, has no baseline: the tests of its group have to fail.
The exit code is 1 if a mutation survives that `mutants.toml` does not call equivalent, with a reason, or if one called
so is noticed.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from maglev.files.packages import PACKAGES
from maglev.runs.baseline_check import check_run
from maglev.runs.preparation import prepare
from maglev.scenario.catalogue import HOST, build
from maglev.scenario.layers import PACKAGED
from maglev.scenario.loading import load_plans
from maglev.scenario.run_plan import RunPlan

ROOT = Path(__file__).parents[1]
LIST = Path(__file__).with_suffix(".toml")
COPIED = (*PACKAGES, "scenarios", "stages")
TESTED = ("tests", "docs")   # and what tests read
BUILD = """
import sys
from pathlib import Path
from maglev.scenario.catalogue import HOST, build
build(sys.argv[2:], Path(sys.argv[1]), HOST)
"""


class Mutation(NamedTuple):
    """A changed line of a file of the repository, the FMUs to rebuild, and the runs or tests that may notice it.

    `equivalent` says why nothing follows from it; empty where it has to be noticed.
    """

    group: str
    file: str
    old: str
    new: str
    fmus: tuple[str, ...]
    runs: tuple[str, ...]
    tests: tuple[str, ...]
    equivalent: str

    def source(self) -> str:
        """The changed file; ValueError if the old text does not stand in it exactly once."""
        text = (ROOT / self.file).read_text(encoding="utf-8")
        if text.count(self.old) != 1:
            raise ValueError(f"{self.file}: {self.old!r} occurs {text.count(self.old)} times, expected once")
        return text.replace(self.old, self.new)

    def __str__(self) -> str:
        old, new = " ".join(self.old.split()), " ".join(self.new.split())
        return f"{self.file}: {old}  ->  {new or 'nothing'}"


def read_mutations() -> list[Mutation]:
    """Mutations of `mutants.toml`, in its order."""
    groups = tomllib.loads(LIST.read_text(encoding="utf-8"))["groups"]
    return [Mutation(name, mutation.get("file", group.get("file")), mutation["old"], mutation["new"],
                     tuple(group.get("fmus", ())), tuple(mutation.get("runs", group.get("runs", ()))),
                     tuple(group.get("tests", ())), mutation.get("equivalent", ""))
            for name, group in groups.items() for mutation in group["mutations"]]


def named_plans(runs: Sequence[str]) -> list[RunPlan]:
    """Plans of runs; the name of a scenario stands for its variants."""
    return [plan for name in runs for plan in load_plans(name)]


def copied_packages(source: Path, *further: str) -> Path:
    """A folder with a copy of the packages, and of further folders."""
    for name in (*COPIED, *further):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__", "baselines"))
    for name in ("pyproject.toml", "LICENSE"):
        shutil.copy(ROOT / name, source)
    return source


def mutated_fmus(mutation: Mutation, folder: Path, unchanged: Path) -> str:
    """Build the FMUs of a mutation next to links to the unchanged ones; what the compiler refuses, in a line."""
    source, fmus = copied_packages(folder / "source", *(TESTED if mutation.tests else ())), folder / "fmus"
    (source / mutation.file).write_text(mutation.source(), encoding="utf-8")
    fmus.mkdir()
    if not mutation.fmus:
        return ""
    for fmu in unchanged.glob("*.fmu"):
        if fmu.stem not in mutation.fmus:
            (fmus / fmu.name).symlink_to(fmu)
    done = subprocess.run([sys.executable, "-c", BUILD, str(fmus), *mutation.fmus], cwd=folder, text=True,
                          capture_output=True, env={**os.environ, "PYTHONPATH": str(source)})
    return "" if done.returncode == 0 else (done.stderr or done.stdout).strip().splitlines()[-1]


def noticed(plans: Sequence[RunPlan], fmus: Path) -> str:
    """Return the message of the first run that does not pass, also with FMUs of other sources; empty if all pass."""
    for plan in plans:
        result = check_run(PACKAGED / "baselines", replace(prepare(plan, fmus, {}, {}), stale=()), {})
        if result.status != "passed":
            return f"{plan.name} {result.message}"
    return ""


def failing_test(tests: Sequence[str], source: Path) -> str:
    """Return pytest's message about the first test that fails with copied sources; empty if all pass."""
    done = subprocess.run([sys.executable, "-m", "pytest", "-x", "--no-header", "-p", "no:cacheprovider", *tests],
                          cwd=source, text=True, capture_output=True, env={**os.environ, "PYTHONPATH": str(source)})
    failed = [line for line in done.stdout.splitlines() if line.startswith("FAILED ")]
    if not failed and done.returncode:
        raise RuntimeError(f"{' '.join(tests)}: {(done.stdout + done.stderr)[-500:]}")
    return "".join(failed[:1])


def chosen_mutations(mutations: Sequence[Mutation], words: Sequence[str]) -> list[tuple[int, Mutation]]:
    """Numbered mutations, those that any of the words is for."""
    return [(k, mutation) for k, mutation in enumerate(mutations, 1)
            if not words or any(word == str(k) or (not word.isdigit() and word in f"{mutation.group} {mutation}")
                                for word in words)]


def main() -> int:
    """Try mutations, print what became of each, and count those that are not as expected."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", help="numbers, or parts of group, file or text")
    words = parser.parse_args().words
    mutations = chosen_mutations(read_mutations(), words)
    wrong: list[str] = []
    with tempfile.TemporaryDirectory(prefix="mutants-") as temporary:
        unchanged = Path(temporary) / "unchanged"
        plans = {run: named_plans([run]) for _, mutation in mutations for run in mutation.runs}
        used = {str(fmu.model) for some in plans.values() for plan in some for fmu in plan.fmus.values()}
        build(used, unchanged, HOST)
        tests = list(dict.fromkeys(test for _, mutation in mutations for test in mutation.tests))
        failure = noticed([plan for some in plans.values() for plan in some], unchanged) or (
            failing_test(tests, copied_packages(Path(temporary) / "source", *TESTED)) if tests else "")
        if failure:
            print(f"without a mutation: {failure}")
            return 1
        for number, mutation in mutations:
            folder = Path(temporary) / str(number)
            failure = mutated_fmus(mutation, folder, unchanged)
            text = f"cannot be built: {failure}" if failure else noticed(
                named_plans(mutation.runs), folder / "fmus") or (
                failing_test(mutation.tests, folder / "source") if mutation.tests else "")
            shutil.rmtree(folder)
            expected = bool(text) != bool(mutation.equivalent) and not failure
            verdict = "noticed" if text else "survived"
            print(f"{number:3d} {verdict:8s} {mutation}", flush=True)
            print(f"             {text or mutation.equivalent or 'by no run'}", flush=True)
            if not expected:
                wrong.append(f"{number} {verdict}: {mutation}")
    print(f"{len(mutations)} mutations, {len(wrong)} not as expected", *wrong, sep="\n  ")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
