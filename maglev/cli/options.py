"""Options that commands of the command line share."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from maglev.cosim.port_map import PortMap, read_port_maps
from maglev.cosim.wiring import Order
from maglev.errors import QuantityError, ScenarioError
from maglev.experiment.replacement import Replacement
from maglev.identification.model_file import model_settings
from maglev.schema.scenario import Scenario
from maglev.units import number_or_text, parse_quantity

Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]
Fmus = Annotated[Path, typer.Option("--fmus", help="Folder with the built FMUs.")]
Native = Annotated[bool, typer.Option("--native", help="The FMUs that need no Python, of the folder's folder native.")]
Names = Annotated[list[str] | None, typer.Argument(
    metavar="SCENARIO", help="Scenarios or variants (see `maglev list`), or TOML files.", show_default=False)]
Everything = Annotated[bool, typer.Option("--all", help="Every scenario of the package.")]
Settings = Annotated[list[str] | None, typer.Option(
    "--set", metavar="FMU.variable=value", help="Start value that goes before the scenario's; may carry a unit and may "
    "be repeated.", show_default=False)]
Model = Annotated[Path | None, typer.Option("--model", metavar="TOML", help="Constants of plant and controller, as "
                                            "`maglev identify` writes them; --set goes before them.",
                                            show_default=False)]
Plant = Annotated[Path | None, typer.Option(help="Another plant FMU, with the same ports or a map.",
                                            show_default=False)]
Controller = Annotated[Path | None, typer.Option(help="Another controller FMU, with the same ports or a map.",
                                                 show_default=False)]
PortsFile = Annotated[Path | None, typer.Option("--map", metavar="TOML", help="What the other FMUs call their ports, "
                                                "their units and steps (docs/importing.md).", show_default=False)]
Step = Annotated[str | None, typer.Option(help="Communication step, in s or with a unit.", show_default=False)]
Ordering = Annotated[Order, typer.Option(
    "--order", help="Order of the FMUs in a step: one after the other (sequential), or all with what the step before "
    "gave (jacobi), which delays the loop by a step.")]
Out = Annotated[Path, typer.Option(help="Folder for the results.")]
Jobs = Annotated[int | None, typer.Option(
    min=1, help="Runs at a time, each in a process of its own; as many as processors if not given.",
    show_default=False)]

RIG_OF_AXIS = {"v": "2dof", "y": "3dof"}   # the vertical axes


def replacements(plant: Path | None, controller: Path | None, ports: Path | None) -> dict[str, Replacement]:
    """FMUs that take the place of a scenario's, by participant, with their maps."""
    given = {name: path for name, path in (("plant", plant), ("controller", controller)) if path is not None}
    maps = {} if ports is None else read_port_maps(ports)
    for name in maps:
        if name not in given:
            raise ScenarioError(f"{ports}: [{name}]: expected --{name} with it")
    if ports is not None and not maps:
        raise ScenarioError(f"--map {ports}: expected a table [controller] or [plant] in it")
    return {name: Replacement(path, maps.get(name, PortMap())) for name, path in given.items()}


def given_settings(settings: Settings, model: Model, runs: Sequence[Scenario]) -> list[str]:
    """Start values of the options --model and --set, in the order in which they go over each other."""
    if model is None:
        return settings or []
    rigs = {rig for run in runs for axis, rig in RIG_OF_AXIS.items() if axis in run.axis_names}
    if len(rigs) != 1:
        raise ScenarioError(f"--model {model}: expected runs of one rig, got {' and '.join(sorted(rigs)) or 'none'}")
    constants = model_settings(model, rigs.pop())
    for run in runs:
        for name, fmu in run.fmus.items():
            for variable, source in fmu.start_from.items():
                if any(constant.startswith(f"{name}.{variable}=") for constant in constants):
                    raise ScenarioError(f"--model {model}: {run.name} takes {name}.{variable} from {source.run}, "
                                        "expected only runs that take no constants from others")
    return [*constants, *(settings or [])]


def chosen_folder(fmus: Path, native: bool) -> Path:
    """Folder of the FMUs of this project."""
    return fmus / "native" if native else fmus


def read_step(text: str | None) -> float | None:
    """Communication step (s) of the option --step."""
    if text is None:
        return None
    try:
        return parse_quantity(number_or_text(text), "s")
    except QuantityError as error:
        raise ScenarioError(f"--step {text}: {error}") from error
