"""Options that commands of the command line share."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from inspect import signature
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from maglev.descriptions import EXAMPLE
from maglev.files.errors import MaglevError, ScenarioError
from maglev.scenario.options import OPTIONS, Format, Option, with_options

VALUE = "a name, = and a value with its unit, such as y=25mm"
MORE = "More"   # group in the help
ANY_STAGE = f"Name of a stage, such as `{EXAMPLE}`, or a TOML file."   # help of an option


def run_names(beginning: str) -> list[str]:
    """Names of scenarios and runs that begin so, for the shell."""
    from maglev.scenario.layers import packaged_files, packaged_runs

    return [name for name in dict.fromkeys([*packaged_files(), *packaged_runs()]) if name.startswith(beginning)]


Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.", rich_help_panel=MORE)]
Built = Annotated[Path, typer.Option("--fmus", metavar="FOLDER", help="Folder of FMUs.")]
Names = Annotated[list[str] | None, typer.Argument(
    metavar="SCENARIO", help="Names from `maglev list`, or TOML files.", show_default=False, autocompletion=run_names)]
NamesOrFmus = Annotated[list[str] | None, typer.Argument(
    metavar="SCENARIO", help="Names from `maglev list`, TOML files, or FMUs.", show_default=False,
    autocompletion=run_names)]
StageFile = Annotated[Path | None, typer.Option("--stage", metavar="TOML", help="Description of your own stage.",
                                                show_default=False)]
All = Annotated[bool, typer.Option("--all", help="Run every scenario of the package.")]
AsJson = Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Also write the results as JSON.",
                                             show_default=False)]
Out = Annotated[Path, typer.Option(metavar="FOLDER", help="Folder for the results.")]
Form = Annotated[Format, typer.Option("--format", rich_help_panel=MORE, metavar="FORMAT",
                                      help="Recorded signals: `csv` or `parquet`.")]
Every = Annotated[int | None, typer.Option("--every", metavar="N", help="Record every N-th communication step.",
                                           rich_help_panel=MORE)]
Claims = Annotated[Literal["thesis"] | None, typer.Option(
    "--claims", metavar="thesis", help="Show the thesis's claims for a loop of your own.", show_default=False,
    rich_help_panel=MORE)]
Jobs = Annotated[int | None, typer.Option(
    min=1, metavar="N", help="Parallel processes; by default one a processor.", show_default=False,
    rich_help_panel=MORE)]


def typed(option: Option) -> Any:
    """Return the type by which typer reads an option, and its help."""
    numbers = {} if option.typed is not int else {"min": option.choices[0], "max": option.choices[-1]}
    kind = option.typed if option.default is not None else option.typed | None
    return Annotated[kind, typer.Option(
        option.flag, help=option.help, metavar=option.metavar, rich_help_panel=option.group or None,
        show_default=option.default is not None, **numbers)]


# Options of runs, by name: the annotation for typer, and the default.
RUN_OPTIONS = {name: (typed(option), option.default) for name, option in OPTIONS.items()}

Command = Callable[..., None]


def with_run_options(names: Iterable[str]) -> Callable[[Command], Command]:
    """Give a command some options of runs, after its own, instead of `**options`."""
    return with_more({name: option for name, option in RUN_OPTIONS.items() if name in {*names}})


def with_more(options: Mapping[str, tuple[Any, object]]) -> Callable[[Command], Command]:
    """Give a command options, annotation and default by name, instead of its `**options`."""
    def extended(command: Command) -> Command:
        command.__signature__ = with_options(signature(command), options)   # type: ignore[attr-defined]  # typer's
        return command
    return extended


def pairs(flag: str, words: Iterable[str] | None, expected: str, error: type[MaglevError] = ScenarioError
          ) -> Iterator[tuple[str, str]]:
    """Return names and values of words `name=value` of an option; raise an error for any other word."""
    for word in words or ():
        name, _, value = map(str.strip, word.partition("="))
        if not (name and value):
            raise error(f"{flag} {word}: expected {expected}")
        yield name, value


def option_value(text: str) -> float | str | bool:
    """Return a value of an option: true, false, a number, or a quantity with its unit."""
    from maglev.files.units import number_or_text

    return text == "true" if text in ("true", "false") else number_or_text(text)
