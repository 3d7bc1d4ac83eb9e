"""Options that commands of the command line share."""

from collections.abc import Callable
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Annotated, Any

import typer

from maglev.cosim.order import Order
from maglev.experiment.form import Format
from maglev.kinds import KindName
from pmlsm.rigs import RIGS

RIG_NAMES = " or ".join(f"`{name}`" for name in RIGS)
AXIS_NAMES = ", or ".join(", ".join(f"`{axis}`" for axis in rig.axis_names) for rig in RIGS.values())


def run_names(beginning: str) -> list[str]:
    """Names of scenarios and runs that begin so, for the shell."""
    from maglev.schema.layers import packaged_files, packaged_runs

    return [name for name in dict.fromkeys([*packaged_files(), *packaged_runs()]) if name.startswith(beginning)]


Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]
Fmus = Annotated[Path | None, typer.Option(
    "--fmus", help="Folder with FMUs that fly as they are; if not given, what is needed is built where it is missing, "
    "and kept for all runs (`maglev cache`).", show_default=False)]
Built = Annotated[Path, typer.Option("--fmus", help="Folder for FMUs.")]
Kind = Annotated[KindName | None, typer.Option("--kind", help="FMUs of this project that need no Python, `native`, or "
                                               "`python`; the results are the same. Of --fmus native ones are in the "
                                               "folder native.", show_default="native where there is a compiler")]
Fmi = Annotated[int, typer.Option("--fmi", min=2, max=3, help="3 for native FMUs of FMI 3.0; of --fmus in the folder "
                                  "fmi3.")]
Names = Annotated[list[str] | None, typer.Argument(
    metavar="SCENARIO", help="Scenarios or variants (see `maglev list`), or TOML files.", show_default=False,
    autocompletion=run_names)]
NamesOrFmus = Annotated[list[str] | None, typer.Argument(
    metavar="SCENARIO", help="Scenarios or variants (see `maglev list`), or TOML files; or FMUs, whose own experiments "
    "are flown.", show_default=False, autocompletion=run_names)]
RigFile = Annotated[Path | None, typer.Option("--rig", metavar="TOML", help="Description of a stage of yours "
                                              "(docs/own_stage.md).", show_default=False)]
Everything = Annotated[bool, typer.Option("--all", help="Every scenario of the package.")]
Settings = Annotated[list[str] | None, typer.Option(
    "--set", metavar="FMU.variable=value", help="Start value that goes before the scenario's; may carry a unit and may "
    "be repeated.", show_default=False)]
Parameters = Annotated[list[str] | None, typer.Option(
    "--parameters", metavar="[FMU=]SSV", help="Start values from a parameter set (SSV), of an FMU or with its "
    "name before each. They go before the scenario's and those of --model, --set before them.", show_default=False)]
Model = Annotated[Path | None, typer.Option(
    "--model", metavar="TOML", help="Constants of plant and controller, as `maglev identify` writes them; or `plant`: "
    "the controller's model follows the masses of the plant. --set goes before them.", show_default=False)]
Plant = Annotated[Path | None, typer.Option(help="Another plant, as `--controller`.",
                                            show_default=False)]
Controller = Annotated[Path | None, typer.Option(help="Another controller: an FMU of this project by its name, "
                                                 "an FMU with the same ports or a map, or a Python file with a class "
                                                 "(docs/controllers.md).",
                                                 show_default=False)]
KeepSettings = Annotated[bool, typer.Option(
    "--keep-settings", help="Give the other controller also the settings (gains, limits) of the scenario's, where it "
    "has parameters of their names; otherwise only FMUs of this project share them.")]
PortsFile = Annotated[Path | None, typer.Option("--map", metavar="TOML", help="What the other FMUs call their ports, "
                                                "their units and steps (docs/importing.md).", show_default=False)]
Step = Annotated[str | None, typer.Option(help="Communication step, in s or with a unit.", show_default=False)]
Timeout = Annotated[str, typer.Option(help="Longest time that a call of an FMU which is not of this project may take, "
                                      "in s or with a unit.")]
Ordering = Annotated[Order, typer.Option(
    "--order", help="Order of the FMUs in a step: one after the other (sequential), or all with what the step before "
    "gave (jacobi), which delays the loop by a step.")]
AsJson = Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Also write what was found as JSON.",
                                             show_default=False)]
Out = Annotated[Path, typer.Option(help="Folder for the results.")]
Form = Annotated[Format, typer.Option("--format", help="Of the columns: csv, or parquet, with units and provenance.")]
Every = Annotated[int | None, typer.Option("--every", metavar="N", help="Write every N-th communication step, in "
                                           "place of the scenario's output interval.", show_default=False)]
Jobs = Annotated[int | None, typer.Option(
    min=1, help="Runs at a time, in as many processes; as many as processors if not given.",
    show_default=False)]

# How runs differ from their plans: `FlightOptions` of `maglev.api.options`.
FLIGHT: dict[str, tuple[Any, object]] = {
    "set": (Settings, None), "parameters": (Parameters, None), "model": (Model, None), "plant": (Plant, None),
    "controller": (Controller, None), "ports": (PortsFile, None), "keep_settings": (KeepSettings, False),
    "step": (Step, None), "order": (Ordering, "sequential"), "fmus": (Fmus, None), "kind": (Kind, None),
    "fmi": (Fmi, 2), "timeout": (Timeout, "60 s")}


def with_flight_options(*left_out: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command, in place of its `**options`, those of `FLIGHT` but for some, after its own."""
    def extended(command: Callable[..., None]) -> Callable[..., None]:
        own = [each for each in signature(command).parameters.values() if each.kind is not Parameter.VAR_KEYWORD]
        shared = [Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=kind)
                  for name, (kind, default) in FLIGHT.items() if name not in left_out]
        command.__signature__ = Signature([*own, *shared])   # type: ignore[attr-defined]  # where typer looks
        return command
    return extended
