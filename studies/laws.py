"""Laws that maps are flown of, and what the studies of such maps share: their command line, flights, and origin."""

import argparse
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TypeVar

import maglev
from maglev.maps.rows import Origin
from maglev.studies.dataset import metadata_of
from maglev.studies.schema import StudyFile

LAWS = {"2dof": ("nonlinear", "linear", "pid"), "3dof": ("nonlinear", "linear", "scheduled", "pid"),
        "5dof": ("nonlinear", "linear", "pid")}
NAMES = {"pid": "PID"}

Fly = Callable[[StudyFile], Path]   # a study to its dataset
Maps = TypeVar("Maps")


def map_laws(words: str, data: Path, read: Callable[[Path], dict[str, Maps]],
             write: Callable[[Path, dict[str, Maps]], None],
             fly_rig: Callable[[str, tuple[str, ...], Fly, argparse.Namespace], Maps]) -> None:
    """Fly rigs as the command line asks for, and write what was found; with --rig the others stay as they are.

    `words` say what the command does, and maps stand in `data` if the command line names no file. `fly_rig` flies the
    laws of a rig and draws them: name of the rig, its laws, how to fly a study, options.
    """
    parser = argparse.ArgumentParser(description=words, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rig", choices=LAWS)
    parser.add_argument("--out", type=Path, default=Path("results"))
    parser.add_argument("--docs", type=Path, default=Path("docs"))
    parser.add_argument("--data", type=Path, default=data)
    parser.add_argument("--jobs", type=int)
    options = parser.parse_args()

    def fly(study: StudyFile) -> Path:
        return maglev.study(study, native=True, out=options.out, jobs=options.jobs, resume=True).path

    rigs = read(options.data) if options.rig else {}
    for rig in [options.rig] if options.rig else LAWS:
        rigs[rig] = fly_rig(rig, LAWS[rig], fly, options)
    write(options.data, rigs)


def origin_of(paths: Iterable[Path]) -> Origin:
    """What studies' datasets rest on: their versions, commits, where known, and FMUs."""
    found = [metadata_of(path)["provenance"] for path in paths]
    commits = sorted({each["commit"] for each in found} - {None})
    return Origin(", ".join(sorted({each["version"] for each in found})), ", ".join(commits) or None,
                  {fmu["model"]: fmu["guid"] for each in found for fmu in each["fmus"]})


def markdown_table(rows: Sequence[Sequence[str]]) -> str:
    """Rows of texts, the heading first, as a table in Markdown; all but the first two columns are numbers."""
    head, *others = (f"| {' | '.join(row)} |" for row in rows)
    return "\n".join([head, "|---|---|" + "---:|" * (head.count("|") - 3), *others])
