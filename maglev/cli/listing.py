"""The command `maglev list`: scenarios and FMUs in a line each, or all about those with a word in their names."""

from collections.abc import Sequence
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import maglev
from maglev.cli.options import Built, Debug, StageFile
from maglev.cli.terminal import one_line_errors, report_console
from maglev.files.errors import ScenarioError

if TYPE_CHECKING:
    from maglev.api.catalogue import FmuEntry, RunEntry
    from maglev.files.console import ResultTable

MOST_NAMED = 7   # variants of a scenario that are named

Words = Annotated[list[str] | None, typer.Argument(metavar="WORD", show_default=False,
                                                   help="Part of a name: list its FMUs and runs in detail.")]


def list_all(words: Words = None, stage: StageFile = None, fmus: Built = Path("fmus"), debug: Debug = False) -> None:
    """List the scenarios and the FMUs, or the FMUs of your own stage.

    List all in short, then the runs and FMUs with a word in their names:

        maglev list
        maglev list setpoints
        maglev list Plant

    List the FMUs of your own stage:

        maglev new stage mine.toml
        maglev list --stage mine.toml
    """
    with one_line_errors(debug):
        entries, runs = maglev.fmus(stage), [] if stage is not None else maglev.scenarios()
        for word in words or ():
            entries = [entry for entry in entries if word.lower() in entry.name.lower()]
            runs = [run for run in runs if word.lower() in run.name.lower()]
        if words and not entries and not runs:
            raise ScenarioError(f"{' '.join(words)}: no FMU and no run has this in its name; `maglev list` lists all")
        console = report_console()
        if words or stage is not None:
            for table in ([fmu_table(entries, fmus)] if entries else []) + ([run_table(runs)] if runs else []):
                console.print(table)
            return
        console.print(kind_table(entries, fmus))
        console.print("yes: built, in the cache or in the folder --fmus; no: a run builds it")
        console.print(scenario_table(runs))
        console.print("`maglev list WORD` prints details of the names with this word")


def built_kinds(entry: "FmuEntry", fmus: Path) -> list[str]:
    """Return where an FMU is built: kinds in the cache, then kinds in the folder; stale if the sources have changed."""
    from maglev.descriptions.own_fmus import stale
    from maglev.scenario.catalogue import HOST, PYTHON
    from maglev.scenario.fmus_for_runs import is_kept

    kinds = {"Python": entry.file(fmus), "native": entry.file(fmus / "native"), "FMI 3.0": entry.file(fmus / "fmi3"),
             "clocked": entry.file(fmus / "clocked")}
    cached = [f"{word} in the cache"
              for word, kind in (("native", HOST), ("Python", PYTHON), ("FMI 3.0", HOST._replace(fmi=3)))
              if entry.ending == "fmu" and is_kept(entry.name, kind)]
    return cached + [f"{kind} in {file.parent}{' (stale)' if stale(entry.name, file) else ''}"
                     for kind, file in kinds.items() if file.is_file()]


def fmu_table(entries: Sequence["FmuEntry"], fmus: Path) -> "ResultTable":
    from maglev.files.console import ResultTable

    return ResultTable("", ("FMU", "built", "description"), (
        [entry.name, ", ".join(built_kinds(entry, fmus)) or "no", entry.description] for entry in entries), left=3)


def run_table(runs: Sequence["RunEntry"]) -> "ResultTable":
    from maglev.files.console import ResultTable

    return ResultTable("", ("run", "description"), (
        [run.name, f"{run.title} (Fig. {', '.join(run.figures)})" if run.figures else run.title]
        for run in runs), left=2)


def kind_table(entries: Sequence["FmuEntry"], fmus: Path) -> "ResultTable":
    """A row for each kind of FMU, with whether that of each stage is built."""
    from maglev.descriptions.packaged import PACKAGED_STAGES
    from maglev.files.console import ResultTable

    suffixes = {stage.suffix: stage.name for stage in PACKAGED_STAGES.values()}
    kinds: dict[str, dict[str, FmuEntry]] = {}
    for entry in entries:
        suffix = next(suffix for suffix in suffixes if entry.name.endswith(suffix))
        kinds.setdefault(entry.name.removesuffix(suffix), {})[suffix] = entry
    return ResultTable("", ("FMU", "description", *suffixes), (
        [kind, summary(of), *("" if suffix not in of else built_word(built_kinds(of[suffix], fmus))
                             for suffix in suffixes)] for kind, of in kinds.items()), left=2)


def built_word(kinds: Sequence[str]) -> str:
    current = [kind for kind in kinds if not kind.endswith("(stale)")]
    return "yes" if current else "stale" if kinds else "no"


def summary(of: dict[str, "FmuEntry"]) -> str:
    """Return the description that all FMUs of one kind share."""
    texts = []
    for suffix, entry in of.items():
        text = entry.description.replace(f" of the {suffix[0]}-DOF stage", "").replace(suffix, "")
        texts.append(text.removeprefix(f"{suffix[0]}-DOF ").partition(":")[0].partition(",")[0])
    same = takewhile(lambda words: len(set(words)) == 1, zip(*(text.split() for text in texts), strict=False))
    shared = " ".join(words[0] for words in same)
    return shared if shared in texts else f"{shared} …"


def scenario_table(runs: Sequence["RunEntry"]) -> "ResultTable":
    """A row for each scenario: its title, or the names of its variants."""
    from maglev.files.console import ResultTable

    rows = []
    for scenario in dict.fromkeys(run.scenario for run in runs):
        variants = [run for run in runs if run.scenario == scenario]
        if len(variants) == 1:
            rows.append([variants[0].name, variants[0].title.partition(" stage: ")[2] or variants[0].title])
            continue
        names = [run.name.removeprefix(f"{scenario}-") for run in variants]
        rows.append([f"{scenario}-…", ", ".join(names) if len(names) <= MOST_NAMED + 1 else
                     f"{', '.join(names[:MOST_NAMED])} and {len(names) - MOST_NAMED} others"])
    return ResultTable("", ("run", "description, or variants"), rows, left=2)
