"""A console that prints texts of others, of FMUs and files, and obeys nothing in them; and narrow tables."""

import re
from collections.abc import Iterable, Sequence
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console, ConsoleOptions, ConsoleRenderable, RenderHook, RenderResult
from rich.segment import Segment
from rich.table import Column, Table
from rich.text import Text

from maglev.errors import visible


class Escaped:
    """What is printed, with escapes in place of control characters."""

    def __init__(self, printed: ConsoleRenderable):
        self.printed = printed

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for segment in console.render(self.printed, options):
            yield segment if segment.control else Segment(visible(segment.text), segment.style)


class Escapes(RenderHook):
    """Has a console print everything `Escaped`."""

    def process_renderables(self, renderables: list[ConsoleRenderable]) -> list[ConsoleRenderable]:
        return [Escaped(printed) for printed in renderables]


def plain_console(**options: Any) -> Console:
    """Console whose control sequences are its own, and that prints in a notebook as elsewhere; options as of rich's.

    Texts in brackets are no markup: styles are those of `rich.text.Text`.
    """
    console = Console(force_jupyter=False, markup=False, **options)
    console.push_render_hook(Escapes())
    return console


def heading(name: str, title: str) -> Text:
    return Text.assemble((name, "bold"), f": {title}")


def result_table(title: str, heads: Sequence[str], rows: Iterable[Sequence[str | Text] | None], left: int = 1) -> Table:
    """Table with two spaces between columns; None is a line between rows, strings are text and no markup.

    What is on the left wraps where it has to. The other columns are numbers, which are never broken: their heads are.
    """
    cells = [[cell if isinstance(cell, Text) else Text(cell) for cell in row or ()] for row in rows]
    columns = [Column(Text(head), overflow="fold") for head in heads[:left]]
    for k, head in enumerate(heads[left:], start=left):
        parts = BREAK.split(head)
        room = max(len(text.strip()) for text in (*parts, *(row[k].plain for row in cells if k < len(row))))
        lines = [""]
        for part in parts:
            lines[len(lines):] = [""] if len((lines[-1] + part).rstrip()) > room else []
            lines[-1] += part
        columns.append(Column(Text("\n".join(map(str.rstrip, lines))), justify="right", no_wrap=True, vertical="top"))
    table = Table(*columns, title=Text(f"\n{title}", style="table.title") if title else None, title_justify="left",
                  box=SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    for row in cells:
        if row:
            table.add_row(*row)
        else:
            table.add_section()
    return table


BREAK = re.compile(r"(?<=\D )|(?<=-)|(?<=[a-z]\.)|(?<=[a-z])(?=[A-Z])")   # where a head may go on below, not "10 µm"
