"""Run every experiment for the site, a page for each: `python docs/site/experiments.py FOLDER`."""

import shutil
import sys
import tempfile
from pathlib import Path

import maglev
from maglev.api.catalogue import RunEntry
from maglev.files.pictures import write_figure
from maglev.pages.live_content import live_address, live_runs
from maglev.pages.picture import figure_of


def page_of(runs: list[RunEntry], picture: str, live: set[str]) -> str:
    """Page of a scenario: what it is, its picture, and what each of its runs consists of."""
    first = runs[0]
    text = f"# {first.scenario}\n\n{first.title}.\n\n"
    if first.figures:
        text += f"Of the thesis: {', '.join(f'figure {figure}' for figure in first.figures)}.\n\n"
    text += f"    maglev run {first.scenario} --plot\n\n{picture}\n\n"
    text += "| run | what it is | command | |\n|---|---|---|---|\n"
    for run in runs:
        link = f'<a href="../../stage/{live_address(run.name)}">live</a>' if run.name in live else ""
        text += f"| {run.name} | {run.title.replace('|', ',')} | `maglev run {run.name}` | {link} |\n"
    return text


def picture_of(name: str, path: Path) -> str:
    """Picture of a run, written as PNG, in Markdown; or why there is none."""
    with tempfile.TemporaryDirectory() as folder:   # as many runs, for some start from the ends of others
        runs = maglev.run_all([name], out=folder).runs
    own = next(run for run in runs if run.plan.name == name)
    if own.failure is not None:
        return f"It does not come to its end: {own.failure}"
    write_figure(path, figure_of(own))
    return f"![{name}: positions, errors and currents]({path.name})"


def write_pages(folder: Path, live: set[str]) -> None:
    """Write `SCENARIO.md` for each scenario, with a picture of its first run."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    runs: dict[str, list[RunEntry]] = {}
    for run in maglev.scenarios():
        runs.setdefault(run.scenario, []).append(run)
    for scenario, entries in runs.items():
        picture = picture_of(entries[0].name, folder / f"{scenario}.png")
        (folder / f"{scenario}.md").write_text(page_of(entries, picture, live), encoding="utf-8")


if __name__ == "__main__":
    made = Path(sys.argv[1])
    has_live = (made.parent / "extra" / "stage" / "live.html").is_file()
    write_pages(made, {plan.name for plan in live_runs()} if has_live else set())
