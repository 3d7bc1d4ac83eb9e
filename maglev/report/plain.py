"""A console that prints texts of others, of FMUs and files, and obeys nothing in them."""

from typing import Any

from rich.console import Console, ConsoleOptions, ConsoleRenderable, RenderHook, RenderResult
from rich.segment import Segment

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
    """Console whose control sequences are its own; options as of rich's."""
    console = Console(**options)
    console.push_render_hook(Escapes())
    return console
