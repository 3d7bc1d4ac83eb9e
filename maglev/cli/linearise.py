"""The command `maglev linearise`: models from equations, by differences, or from measurements."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

import maglev
from maglev.cli.options import (
    MORE,
    VALUE,
    AsJson,
    Debug,
    Out,
    StageFile,
    option_value,
    pairs,
    with_more,
    with_run_options,
)
from maglev.cli.terminal import one_line_errors
from maglev.files.errors import LinearModelError, option
from maglev.scenario.options import FmuOptions

Blocks = Annotated[list[str], typer.Argument(
    metavar="PLANT [[MEASUREMENT] CONTROLLER]", show_default=False, help="FMUs or Python files.")]
At = Annotated[list[str], typer.Option(
    "--at", metavar="AXIS=POSITION", help="Operating point. Repeatable.", show_default=False)]
Measure = Annotated[bool, typer.Option("--measure", help="Measure the running loop by injection.")]
Parameters = Annotated[list[str] | None, typer.Option(
    "--set", metavar="PART.VARIABLE=VALUE", help="Parameter, in SI or with a unit. Repeatable.", show_default=False)]
Openings = Annotated[list[str] | None, typer.Option(
    "--open", metavar="SIGNAL", help="Open the loop here; default: every axis.", show_default=False)]
Plot = Annotated[bool, typer.Option("--plot", help="Write pictures of the loop (needs matplotlib).")]
Settle = Annotated[str, typer.Option(metavar="TIME", help="Longest time to come to rest.", rich_help_panel=MORE)]
SampleTime = Annotated[str | None, typer.Option(
    "--sample-time", metavar="TIME", help="Sample time of a controller file.", show_default=False,
    rich_help_panel=MORE)]


def grouped(kind: Any, group: str, *flag: str, **more: Any) -> Any:
    return Annotated[kind, typer.Option(*flag, rich_help_panel=group, **more)]


# Options of one way only, by the names that what it calls has for them, with their defaults.
ALONE, MEASURED = "Model of a plant or a controller", "Measured response"
MODEL: dict[str, tuple[Any, Any]] = {
    "currents": (grouped(str, ALONE, metavar="KIND", help="Coordinates: `dq` or `phases`."), "dq"),
    "hold": (grouped(str | None, ALONE, metavar="TIME", help="Sample time of a plant with held inputs."), None),
    "forces": (grouped(bool, ALONE, "--forces", help="Make external forces inputs of the plant, too."), False)}
INJECTION: dict[str, tuple[Any, Any]] = {
    "amplitude": (grouped(str, MEASURED, metavar="SIZE", help="Peak of the injected signal."), "100 um"),
    "lowest": (grouped(float, MEASURED, "--from", metavar="W", help="Lowest frequency, rad/s."), 1.0),
    "highest": (grouped(float, MEASURED, "--to", metavar="W", help="Highest frequency, rad/s."), 2000.0),
    "lines": (grouped(int, MEASURED, metavar="N", help="Frequencies, evenly on a log scale."), 48),
    "realisations": (grouped(int, MEASURED, metavar="N", help="Number of multisines."), 3),
    "periods": (grouped(int, MEASURED, metavar="N", help="Recorded periods of each multisine."), 2),
    "smooth": (grouped(bool, MEASURED, "--smooth", help="Leave out Coulomb friction and encoder rounding."), False),
    "linear": (grouped(bool, MEASURED, "--linear/--no-linear", help="Compare with the linear loop.",
                       show_default=False), True)}


@with_run_options(["ports", "timeout", *FmuOptions.__annotations__])
@with_more(MODEL | INJECTION)
def linearise(names: Blocks, at: At, openings: Openings = None, measure: Measure = False, settings: Parameters = None,
              plot: Plot = False, amplifier: Annotated[bool, typer.Option(
                  "--amplifier/--no-amplifier", help="Include the amplifiers' lag.", show_default=False)] = True,
              stage: StageFile = None, sample_time: SampleTime = None, settle: Settle = "10 s",
              out: Out = Path("results"), as_json: AsJson = None, debug: Debug = False, **options: Any) -> None:
    """Linearise a plant, controller or loop: models, poles, margins.

    Plants and controllers of this project are linearised from their equations. Any other FMU or Python file is
    linearised by finite differences, with an error estimate or the reason why it has no derivative.

    `--measure` injects multisines into a measurement. It prints the response of the opened loop with its
    nonlinearities, the coherence, and the margins with their standard errors.

    Print the matrices, equilibrium currents and poles of a plant:

        maglev linearise Plant3DOF --at y=25mm
        maglev linearise Plant3DOF --at y=25mm --hold 0.2ms --set plant.y.mass=7.2kg

    Print poles and margins of a loop, also with a delayed measurement:

        maglev linearise Plant3DOF Regulator3DOF --at y=25mm --open y --plot
        maglev linearise Plant3DOF Measurement3DOF Regulator3DOF --at y=25mm \\
            --set measurement.delay=0.4ms

    Linearise your own controller, by differences and by measurement:

        maglev new controller lqi.py
        maglev linearise Plant3DOF lqi.py --at y=25mm
        maglev linearise Plant3DOF lqi.py --at y=25mm --measure --from 3 --to 600

    Use an axis that tilts, or your own stage:

        maglev linearise Plant5DOF Regulator5DOF --at y=25mm --at roll=3mrad \\
            --open roll
        maglev new stage mine.toml
        maglev linearise PlantMine RegulatorMine --at y=25mm --stage mine.toml

    `--open` takes an axis, `y.measured`, a current such as `alpha.i_q`, or a gap of a tilting stage such as
    `alpha1.gap_measured`.
    """
    with one_line_errors(debug):
        from maglev.cli.linear_models import Asked, by_differences, of_loop, of_one, print_measured
        from maglev.files.pictures import require_matplotlib
        from maglev.files.units import number_or_text, positive_time
        from maglev.linear.parameters import by_part

        if stage is not None:
            maglev.know_stage(stage)
        if plot:
            require_matplotlib()   # what would fail after a run fails before it
        model, injection = ({name: options.pop(name) for name in table} for table in (MODEL, INJECTION))
        files = any(name.endswith((".fmu", ".py")) or ".py:" in name for name in names)
        require_defaults("--measure", {} if measure else injection, INJECTION)
        require_defaults("one model", {} if len(names) == 1 else model, MODEL)
        if len(names) not in (1, 2, 3) or (len(names) == 3 and (files or measure)):
            raise LinearModelError(f"{len(names)} names, expected PLANT, CONTROLLER, PLANT CONTROLLER, or PLANT "
                                   "MEASUREMENT CONTROLLER, the last three of this project")
        if len(names) == 1 and (openings or plot or measure):
            raise LinearModelError("--open, --measure and --plot are for loops, expected a plant and a controller")
        if not amplifier and (files or measure):
            raise LinearModelError("--no-amplifier: cannot be combined with a file or --measure, whose loop runs as "
                                   "it is")
        how = {**options, "stage": stage, "sample_time": None if sample_time is None else number_or_text(sample_time),
               **{name: positive_time(text, LinearModelError, option(name, text))
                  for name, text in (("settle", settle), ("timeout", options["timeout"]))}}
        positions = {axis: number_or_text(value) for axis, value in pairs("--at", at, VALUE, LinearModelError)}
        given = {name: option_value(value) for name, value in pairs("--set", settings, VALUE, LinearModelError)}
        parameters = by_part(given, LinearModelError, "measurement")
        if parameters["measurement"] and len(names) == 2:
            raise LinearModelError(f"--set measurement.{next(iter(parameters['measurement']))}: expected a measurement "
                                   "between plant and controller")
        asked = Asked(names, positions, parameters, openings or (), how, out if plot else None, as_json)
        if measure:
            print_measured(asked, **injection)
        elif files:
            by_differences(asked)
        elif len(names) > 1:
            of_loop(asked, amplifier)
        else:
            of_one(asked, amplifier=amplifier, **model)


def require_defaults(what: str, given: Mapping[str, Any], table: Mapping[str, tuple[Any, Any]]) -> None:
    """Refuse options that have no meaning for the requested model."""
    for name, value in given.items():
        kind, default = table[name]
        if value != default:
            flag = next((flag for flag in kind.__metadata__[0].param_decls), f"--{name}")
            raise LinearModelError(f"{flag.partition('/')[2] or flag}: needs {what}")
