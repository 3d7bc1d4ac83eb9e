"""Ratios of the benchmarks by commit: `python benchmarks/speed_history.py` writes docs/speed.md and docs/speed.svg.

`make bench` adds a file to benchmarks/history. A ratio is of two times of one run on one machine.
"""

import json
import os
import subprocess
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "benchmarks" / "history"
SHOWN = 6   # columns of the table, the last ones

# What is drawn together, by what it is a multiple of.
STEP, PYTHON, WHOLE = "a step, of the C loop", "a step, of the bare Python loop", "a run, of the C loop"
WIDTH, HEIGHT, LEFT, TOP, PANEL = 760, 130, 40, 34, 400
LINE = 14   # from one label to the next

STYLE = """\
    text { font: 11px system-ui, sans-serif; fill: #1c2733; } .title { font-weight: 600; } .end { text-anchor: end; }
    line { stroke: #8495a5; stroke-width: 0.5; } polyline { fill: none; stroke-width: 1.8; }
    .s0 { stroke: #2a6fbb; } .s1 { stroke: #c2571a; } .s2 { stroke: #3f8f4f; }
    text.s0 { stroke: none; fill: #2a6fbb; } text.s1 { stroke: none; fill: #c2571a; }
    text.s2 { stroke: none; fill: #3f8f4f; }
    @media (prefers-color-scheme: dark) {
      text { fill: #e3e9ef; } .s0 { stroke: #7db3ee; } .s1 { stroke: #f0a070; } .s2 { stroke: #86cf94; }
      text.s0 { fill: #7db3ee; } text.s1 { fill: #f0a070; } text.s2 { fill: #86cf94; }
    }
"""

PAGE = """# Speed by version

Ratios of `make bench`: times of one run on one machine, divided by each other, so that they depend little on it.
*C loop*: the translated blocks of controller and plant called in one loop, as they were at eb32d8e, with the C
library's sines; kept since as the unit (`benchmarks/reference`). Before it, each commit's own. *Native*, *Python*: both
as FMUs under our master, every output recorded; Python FMUs are compared with the same blocks called in Python. A *run*
is 3dof-setpoints-improved, measured; with CSV, it is also written. A *sample of a study* is one flight of it.
[What a step costs](accuracy.md#what-a-step-costs) has the times.

![Curves of the ratios over the commits that were measured](speed.svg)

`make bench` adds a file to `benchmarks/history`, and `python benchmarks/speed_history.py` makes this page and its
picture of them. The first two commits have what tables of pages said then.

"""


class Measured(NamedTuple):
    """A commit, when it was made (ISO 8601, UTC), the version, and ratios by group and name."""

    commit: str
    date: str
    version: str
    ratios: dict[str, dict[str, float]]


def history() -> list[Measured]:
    """What was recorded, in the order of the commits."""
    return sorted((Measured(**json.loads(path.read_text(encoding="utf-8"))) for path in FOLDER.glob("*.json")),
                  key=lambda each: each.date)


def head() -> tuple[str, str]:
    """Commit that is checked out, and when it was made (ISO 8601, UTC)."""
    commit, date = subprocess.run(["git", "log", "-1", "--date=iso-strict-local", "--format=%h %cd"], cwd=ROOT,
                                  env={**os.environ, "TZ": "UTC"}, capture_output=True, text=True,
                                  check=True).stdout.split()
    return commit, date


def record(group: str, ratios: Mapping[str, float]) -> None:
    """Add ratios to the file of the commit that is checked out."""
    commit, date = head()
    found = next((each for each in history() if each.commit == commit),
                 Measured(commit, date, version("maglev-fmus"), {}))
    found.ratios.setdefault(group, {}).update({name: round(ratio, 2) for name, ratio in ratios.items()})
    FOLDER.mkdir(exist_ok=True)
    (FOLDER / f"{commit}.json").write_text(json.dumps(found._asdict(), indent=1) + "\n", encoding="utf-8")


def names(entries: list[Measured]) -> dict[str, list[str]]:
    """Names of the ratios of each group."""
    found: dict[str, list[str]] = {group: [] for group in (STEP, PYTHON, WHOLE)}
    for each in entries:
        for group, ratios in each.ratios.items():
            found[group] += [name for name in ratios if name not in found[group]]
    return found


def page(entries: list[Measured]) -> str:
    """The page, with a table of the last commits that were measured."""
    last = entries[-SHOWN:]
    lines = [f"| | {' | '.join(f'{each.commit}, {each.date[:10]}' for each in last)} |", "|---" * (len(last) + 1) + "|"]
    for group, members in names(last).items():
        for name in members:
            cells = [each.ratios.get(group, {}).get(name) for each in last]
            lines.append(f"| {name}: {group} | {' | '.join('' if cell is None else f'{cell:.2f}' for cell in cells)} |")
    return PAGE + "\n".join(lines) + "\n"


def panel(group: str, members: list[str], entries: list[Measured], top: float) -> Iterator[str]:
    """Curves of a group: upwards from 1 or the least below it, with what each has come to beside its end."""
    points = {name: [(k, each.ratios[group][name]) for k, each in enumerate(entries)
                     if name in each.ratios.get(group, {})] for name in members}
    every = [ratio for curve in points.values() for _, ratio in curve]
    least, largest = min(1.0, *every), max(every)

    def place(k: int, ratio: float) -> tuple[float, float]:
        height = (ratio - least) / max(largest - least, 0.1)
        return LEFT + PANEL * k / max(1, len(entries) - 1), top + HEIGHT * (1.0 - height)

    yield f'<text class="title" x="{LEFT}" y="{top - 12:.0f}">{group}</text>'
    for ratio in sorted({least, 1.0, largest}):
        y = place(0, ratio)[1]
        yield f'<line x1="{LEFT}" x2="{LEFT + PANEL}" y1="{y:.1f}" y2="{y:.1f}"/>'
        if ratio == least or top + HEIGHT - y > LINE:
            yield f'<text class="end" x="{LEFT - 6}" y="{y + 4:.1f}">{ratio:.2f}</text>'
    below, left = top - LINE, len(members)
    for name in sorted(members, key=lambda name: -points[name][-1][1]):
        kind = f"s{members.index(name) % 3}"
        curve = [place(*point) for point in points[name]]
        yield f'<polyline class="{kind}" points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in curve)}"/>'
        yield from (f'<circle class="{kind}" fill="none" cx="{x:.1f}" cy="{y:.1f}" r="2.5"/>' for x, y in curve)
        left -= 1
        below = max(min(curve[-1][1], top + HEIGHT - LINE * left), below + LINE)
        yield (f'<text class="{kind}" x="{LEFT + PANEL + 12}" y="{below + 4:.1f}">{points[name][-1][1]:.2f} '
               f"{name}</text>")


def picture(entries: list[Measured]) -> str:
    """The curves as SVG, one panel above the other."""
    groups = {group: members for group, members in names(entries).items() if members}
    step = HEIGHT + TOP + 22
    lines = [line for number, (group, members) in enumerate(groups.items())
             for line in panel(group, members, entries, TOP + number * step)]
    bottom = TOP + len(groups) * step - 14
    for k, each in list(enumerate(entries))[::-1 - len(entries) // 8]:   # as many names as have room
        x = LEFT + PANEL * k / max(1, len(entries) - 1)
        lines.append(f'<text x="{x:.1f}" y="{bottom}" text-anchor="middle">{each.commit}</text>')
    height = bottom + 10
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" '
            f'height="{height}">\n  <style>\n{STYLE}  </style>\n  ' + "\n  ".join(lines) + "\n</svg>\n")


def main() -> None:
    """Write page and picture."""
    entries = history()
    (ROOT / "docs" / "speed.md").write_text(page(entries), encoding="utf-8")
    (ROOT / "docs" / "speed.svg").write_text(picture(entries), encoding="utf-8")


if __name__ == "__main__":
    main()
