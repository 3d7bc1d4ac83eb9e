"""The map of the house, drawn from the imports: `python tools/house_map.py` writes docs/map.md and docs/map.svg.

A box is a package, or a room (a folder or a file) of the package maglev; a line leads down to what a box imports, and
is left out where a way over others leads there, too.
"""

import ast
from functools import cache
from graphlib import TopologicalSorter
from importlib.util import resolve_name
from pathlib import Path

from maglev.files.packages import OURS

ROOT = Path(__file__).parents[1]
TOOL = "maglev"   # the package that is drawn by its rooms

WIDTH, HEIGHT, GAP, LEVEL = 116, 22, 14, 48   # of a box, between boxes, from one row to the next
SIDE = 6

STYLE = """\
    text { font: 11px system-ui, sans-serif; text-anchor: middle; fill: #1c2733; }
    rect { fill: #eef2f6; stroke: #8495a5; } .blocks rect { fill: #fdf1dc; stroke: #b9924a; }
    path { fill: none; stroke: #8495a5; opacity: 0.8; }
    @media (prefers-color-scheme: dark) {
      text { fill: #e3e9ef; } rect { fill: #26313c; } .blocks rect { fill: #43371f; }
    }
"""

PAGE = """# A map of the house

What imports what, drawn from the code by `python tools/house_map.py`. A box imports only boxes below it that a
line leads to, directly or through others. Yellow boxes are the blocks, which become FMUs; the others are the tool.

![Boxes of packages and rooms, in rows from the command line at the top down to errors and files](map.svg)

| | what it is |
|---|---|
"""


@cache
def imported_lines(path: Path) -> list[tuple[int, str]]:
    """Lines and names of the modules that a file imports: at the top, in functions, and by name as text."""
    package, found = ".".join(path.relative_to(ROOT).parent.parts), []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            found.append((node.lineno, resolve_name("." * node.level + (node.module or ""), package)))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and "_fmu" in node.value:
            # Such as "plant_fmu.definition.plant" of maglev.descriptions.registry; the names of the other packages are plain words.
            found.append((node.lineno, node.value))
    return found


def room_of(module: str) -> str:
    """Room of a module of the tool, such as "cosim" of "maglev.cosim.master"; "__init__" of the package itself."""
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else "__init__"


def box_of(module: str) -> str:
    package = module.split(".")[0]
    return room_of(module) if package == TOOL else package


def arrows() -> dict[str, set[str]]:
    graph: dict[str, set[str]] = {}
    for path in (path for package in OURS for path in sorted((ROOT / package).rglob("*.py"))):
        box = box_of(".".join(path.relative_to(ROOT).with_suffix("").parts))
        reached = {box_of(name) for _, name in imported_lines(path) if name.split(".")[0] in OURS and " " not in name}
        graph[box] = graph.get(box, set()) | reached - {box}
    return {box: reached & graph.keys() for box, reached in graph.items()}


def levels(graph: dict[str, set[str]]) -> dict[str, int]:
    """Row of each box, counted from the ground: one above the highest that it imports."""
    rows: dict[str, int] = {}
    for box in TopologicalSorter(graph).static_order():
        rows[box] = 1 + max((rows[below] for below in graph[box]), default=-1)
    return rows


def reduced(graph: dict[str, set[str]]) -> dict[str, set[str]]:
    """The arrows but for those that a way over others makes superfluous."""
    below: dict[str, set[str]] = {}
    for box in TopologicalSorter(graph).static_order():
        below[box] = graph[box].union(*(below[under] for under in graph[box]))
    return {box: {box for box in reached if not any(box in below[other] for other in reached)}
            for box, reached in graph.items()}


def box_rows(graph: dict[str, set[str]], lines: dict[str, set[str]]) -> list[list[str]]:
    """Boxes row by row from the top, each below the middle of those that import it."""
    level = levels(graph)
    rows: list[list[str]] = []
    place: dict[str, float] = {}
    for number in range(max(level.values()), -1, -1):
        boxes = sorted(box for box in graph if level[box] == number)
        above = {box: [place[row] for row in place if box in lines[row]] for box in boxes}
        boxes.sort(key=lambda box: (sum(above[box]) / len(above[box]) if above[box] else 0.0, box))
        place |= {box: k - (len(boxes) - 1) / 2 for k, box in enumerate(boxes)}
        rows.append(boxes)
    return rows


def drawing() -> str:
    graph = arrows()
    lines = reduced(graph)
    rows = box_rows(graph, lines)
    width = max(map(len, rows)) * (WIDTH + GAP) - GAP + 2 * SIDE
    place = {box: (width / 2 + (k - (len(row) - 1) / 2) * (WIDTH + GAP), SIDE + number * LEVEL)
             for number, row in enumerate(rows) for k, box in enumerate(row)}
    drawn = []
    for box, reached in sorted(lines.items()):
        for x, y in (place[box] for box in sorted(reached)):
            x0, y0 = place[box][0], place[box][1] + HEIGHT
            bend = (y - y0) / 2
            drawn.append(f'  <path d="M{x0:g} {y0:g} C{x0:g} {y0 + bend:g} {x:g} {y - bend:g} {x:g} {y:g}"/>')
    for box, (x, y) in place.items():
        kind = ' class="blocks"' if box.endswith("_fmu") or box == "pmlsm" else ""
        drawn.append(f'  <g{kind}><rect x="{x - WIDTH / 2:g}" y="{y:g}" width="{WIDTH}" height="{HEIGHT}" rx="4"/>'
                     f'<text x="{x:g}" y="{y + 15:g}">{shown(box)}</text></g>')
    height = 2 * SIDE + (len(rows) - 1) * LEVEL + HEIGHT
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height}" width="{width:g}" '
            f'height="{height}">\n  <style>\n{STYLE}  </style>\n' + "\n".join(drawn) + "\n</svg>\n")


def shown(box: str) -> str:
    """Name of a box as people call it."""
    return {"__init__": "import maglev", "__main__": "maglev"}.get(box, box)


def map_page() -> str:
    """The page with the map: from the top, what each box is, as the first line of its docstring says."""
    graph = arrows()
    table = []
    for box in (box for row in box_rows(graph, reduced(graph)) for box in row):
        place = ROOT / box if box in OURS else ROOT / TOOL / box
        file = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
        said = (ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or "").splitlines()[0]
        table.append(f"| `{shown(box)}` | {said} |\n")
    return PAGE + "".join(table)


if __name__ == "__main__":
    (ROOT / "docs" / "map.svg").write_text(drawing(), encoding="utf-8", newline="\n")
    (ROOT / "docs" / "map.md").write_text(map_page(), encoding="utf-8", newline="\n")
