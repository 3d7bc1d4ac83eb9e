"""Help of commands as plain text: examples to paste, and one line for each option where it fits."""

import re
from collections.abc import Callable
from inspect import cleandoc
from typing import Any, TypeVar

import typer
from typer.core import TyperCommand, TyperGroup

WIDEST = 40   # letters of an option and its value, with the explanation in the same line
RANGE = re.compile(r"; (?:\d+<=)?x[<>]=\d+(?=\])|  \[x>=\d+\]")   # of a number
F = TypeVar("F", bound=Callable[..., Any])


def write_help_text(help_text: str | None, formatter: Any) -> None:
    """Write paragraphs without the marks of Markdown, and indented lines as they are: commands, to paste."""
    for paragraph in cleandoc(help_text or "").split("\n\n"):
        formatter.write_paragraph()
        if paragraph.startswith("    "):
            formatter.write(f"{paragraph}\n")
        else:
            formatter.write_text(paragraph.replace("`", ""))


def write_parameters(command: Any, ctx: Any, formatter: Any) -> None:
    """Write arguments, then options in the panels that they name."""
    panels: dict[str, list[tuple[str, str]]] = {}
    for parameter in sorted(command.get_params(ctx), key=lambda each: each.param_type_name != "argument"):
        panel = getattr(parameter, "rich_help_panel", None) or f"{parameter.param_type_name.capitalize()}s"
        if (record := parameter.get_help_record(ctx)) is not None:
            name = record[0].partition(" <")[0]   # without the type
            panels.setdefault(panel, []).append((name, RANGE.sub("", record[1].replace("`", ""))))
    for panel, rows in panels.items():
        with formatter.section(panel):
            formatter.write_dl(rows, col_max=WIDEST)


class PlainHelp:
    """Help of a command as plain text."""

    help: str | None

    def get_short_help_str(self, limit: int = 0) -> str:
        """Return the first paragraph, not cut to a limit, for a list of commands."""
        return cleandoc(self.help or "").split("\n\n")[0]

    def format_help_text(self, ctx: Any, formatter: Any) -> None:
        """Write the paragraphs before the options."""
        write_help_text(self.help, formatter)


class Command(PlainHelp, TyperCommand):
    """A command with help as plain text."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write arguments and options."""
        write_parameters(self, ctx, formatter)


class Commands(PlainHelp, TyperGroup):
    """Commands with a page of their own about all of them."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the commands, then the options of all."""
        self.format_commands(ctx, formatter)
        write_parameters(self, ctx, formatter)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands, each with its first paragraph, in the panels that they name."""
        panels: dict[str, list[tuple[str, str]]] = {}
        for name, command in self.commands.items():
            if not command.hidden:
                line = command.get_short_help_str().replace("`", "")
                panels.setdefault(getattr(command, "rich_help_panel", None) or "Commands", []).append((name, line))
        for panel, rows in panels.items():
            with formatter.section(panel):
                formatter.write_dl(rows)


class Group(typer.Typer):
    """Commands whose help is plain text, without rich, whose imports take longer than NumPy's import."""

    def __init__(self, **settings: Any):
        super().__init__(cls=Commands, no_args_is_help=True, rich_markup_mode=None, **settings)

    def command(self, name: str | None = None, **settings: Any) -> Callable[[F], F]:
        """Return the decorator of a command."""
        return super().command(name, cls=Command, **settings)
