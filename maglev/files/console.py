"""A console that prints texts from FMUs and files but obeys nothing in them, and tables that fit it."""

import re
from collections.abc import Iterable, Sequence
from textwrap import fill
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, ConsoleRenderable, RenderHook, RenderResult
from rich.segment import Segment
from rich.table import Column, Table
from rich.text import Text

from maglev.files.errors import visible
from maglev.files.text_columns import unbroken


class Escaped:
    """Printed text, with escapes instead of control characters."""

    def __init__(self, printed: ConsoleRenderable):
        self.printed = printed

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for segment in console.render(self.printed, options):
            yield segment if segment.control else Segment(visible(segment.text), segment.style)


class Escapes(RenderHook):
    """Make a console print everything `Escaped`."""

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


class ResultTable:
    """A table that cuts no number and no unit, with two spaces between its columns.

    Its `left` columns are texts, which wrap between words, the others numbers; None is a line between rows, and no text
    is markup. If the terminal is too narrow, `spare` columns at the end are left out. Otherwise the table continues
    below with further columns, and repeats the first `keys`, by default those on the left.
    """

    def __init__(self, title: str, heads: Sequence[str], rows: Iterable[Sequence[str | Text] | None], left: int = 1,
                 keys: int | None = None, spare: int = 0):
        self.title, self.spare = title, spare
        self.keys = keys if keys is not None else left if left < len(heads) else 1
        lines = [None if row is None else [as_text(cell) for cell in row] for row in rows]
        self.columns = [ResultColumn(head, [row[k] if row and k < len(row) else Text() for row in lines], k < left)
                        for k, head in enumerate(heads)]
        self.sections = [k for k, row in enumerate(lines) if row is None]

    def __rich_console__(self, _: Console, options: ConsoleOptions) -> RenderResult:
        title = f"\n{self.title}" if self.title else ""
        for columns in self.parts(options.max_width):
            yield self.part(columns, options.max_width, title)
            title = " "

    def parts(self, room: int) -> list[list["ResultColumn"]]:
        """Columns of each part that fits."""
        columns = self.columns
        fewer = columns[:len(columns) - self.spare]
        if width_of(columns) > room >= width_of(fewer):
            columns = fewer
        if width_of(columns) <= room:
            return [columns]
        keys = columns[:self.keys] if 2 * width_of(columns[:self.keys]) <= room else columns[:1]
        parts = [[*keys]]
        for column in columns[len(keys):]:
            if width_of([*parts[-1], column]) > room and len(parts[-1]) > len(keys):
                parts.append([*keys])
            parts[-1].append(column)
        return parts

    def part(self, columns: Sequence["ResultColumn"], room: int, title: str) -> Table:
        widths = shared_widths(columns, room)
        table = Table(*(column.in_width(width) for column, width in zip(columns, widths, strict=True)),
                      title=Text(title, style="table.title") if title else None, title_justify="left",
                      box=SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
        for k in range(len(columns[0].cells)):
            if k in self.sections:
                table.add_section()
            else:
                table.add_row(*(column.cell(k, width) for column, width in zip(columns, widths, strict=True)))
        return table


class ResultColumn:
    """A column: its cells wrap if they are texts, and its head if they are numbers."""

    def __init__(self, head: str, cells: Sequence[Text], wraps: bool):
        self.cells, self.wraps = cells, wraps
        widest = max((cell_len(cell.plain.strip()) for cell in cells), default=0)
        self.head = unbroken(head) if wraps else head_over(head, widest)
        self.widest = max(widest, *map(cell_len, self.head.split("\n")))
        words = [word for text in (Text(self.head), *cells)
                 for word in ([text.plain] if text.no_wrap else unbroken(text.plain).split(" "))]
        self.narrowest = max(min(self.widest, NARROW), *map(cell_len, words)) if wraps else self.widest

    def in_width(self, width: int) -> Column:
        head = Text(wrapped(self.head, width) if self.wraps else self.head)
        return Column(head, width=width, no_wrap=True, overflow="fold", vertical="top",
                      justify="left" if self.wraps else "right")

    def cell(self, row: int, width: int) -> Text:
        cell = self.cells[row]
        return Text(wrapped(cell.plain, width), cell.style) if self.wraps else cell


def as_text(cell: str | Text) -> Text:
    """Return a cell as printed, with escapes instead of control characters, so that its width is right."""
    return Text(visible(cell)) if isinstance(cell, str) else Text(visible(cell.plain), cell.style, no_wrap=cell.no_wrap)


def width_of(columns: Sequence[ResultColumn]) -> int:
    """Width of a table at its narrowest."""
    return sum(column.narrowest for column in columns) + GAP * (len(columns) - 1)


def shared_widths(columns: Sequence[ResultColumn], room: int) -> list[int]:
    """Widths of columns in a table: the widest give way, but never below their narrowest unless one has to."""
    widths, room = [column.widest for column in columns], room - GAP * (len(columns) - 1)
    narrowest = [column.narrowest for column in columns]
    for least in (narrowest, [1 if column.wraps else column.narrowest for column in columns], [1 for _ in columns]):
        while sum(widths) > room and (loose := [k for k, width in enumerate(widths) if width > least[k]]):
            widths[max(loose, key=widths.__getitem__)] -= 1
    return widths


def head_over(head: str, widest: int) -> str:
    """Head of a column of numbers, in as many lines as it takes to be no wider than these, if it can be."""
    parts = BREAK.split(head)
    room = max(widest, *(cell_len(part.strip()) for part in parts))
    lines = [""]
    for part in parts:
        lines[len(lines):] = [""] if cell_len((lines[-1] + part).rstrip()) > room else []
        lines[-1] += part
    return "\n".join(map(str.rstrip, lines))


def wrapped(text: str, width: int) -> str:
    """The text in lines of a width, broken between words, but not between a number and its unit."""
    lines = (fill(line, width, break_on_hyphens=False) for line in unbroken(text).split("\n"))
    return "\n".join(lines).replace("\N{NO-BREAK SPACE}", " ")


GAP = 2       # spaces between columns
NARROW = 20   # letters, to which a column of texts can shrink; further if no word in it is as long
# Places where a head may be broken, not "10 µm".
BREAK = re.compile(r"(?<=\D )|(?<=-)|(?<=[a-z]\.)|(?<=[a-z])(?=[A-Z])|(?=\dDOF)")
