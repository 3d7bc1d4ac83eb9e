"""The command `maglev linearise`: models from equations, by differences, or from measurements."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

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
from maglev.cli.terminal import one_line_errors, write_json
from maglev.files.errors import LinearModelError, option
from maglev.files.pictures import require_matplotlib, write_figure
from maglev.files.units import number_or_text, positive_time
from maglev.scenario.options import FmuOptions

if TYPE_CHECKING:
    from maglev.linear.loop import Loop
    from maglev.linear.margins import Margins
    from maglev.linear.parameters import Quantity

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


@dataclass(frozen=True)
class Asked:
    """The parsed arguments of the command."""

    names: Sequence[str]                         # a plant, a controller, or both
    at: Mapping[str, "Quantity"]                 # positions by axis
    parameters: Mapping[str, dict[str, Any]]     # of "plant", "controller" and "measurement"
    openings: Sequence[str]                      # signals; every axis if there are none
    # for any FMU, which is run: stage, settle, sample_time, options of runs
    how: Mapping[str, Any]
    pictures: Path | None                        # folder, where they are asked for
    json: Path | None                            # file, where it is asked for

    @property
    def both(self) -> dict[str, Any]:
        """Return parameters as arguments of functions of a plant and a controller."""
        return {f"{part}_parameters": values for part, values in self.parameters.items() if part != "measurement"}

    def write(self, data: Mapping[str, object]) -> None:
        if self.json is not None:
            write_json(self.json, data)


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


def of_one(asked: Asked, hold: str | None, **model: Any) -> None:
    """Print the linear model of a plant or a controller."""
    from maglev.linear.parameters import controllers, measurements

    name, = asked.names
    # Options of a plant's model do not apply to a controller: `linearise` raises an error for them.
    own = "controller" if name in controllers() else "measurement" if name in measurements() else "plant"
    for other, given in asked.parameters.items():
        if given and other != own:
            raise LinearModelError(f"--set {other}.{next(iter(given))}: expected {own}.… with {name}")
    linear = maglev.linearise(name, asked.at, hold=None if hold is None else number_or_text(hold),
                              parameters=asked.parameters[own], **model)
    typer.echo(str(linear), nl=False)
    asked.write(linear.as_data())


def of_loop(asked: Asked, amplifier: bool) -> None:
    """Print poles and margins of a loop of this project's plants and controllers, from their equations."""
    from maglev.linear.loop import opening_among, openings_of
    from maglev.linear.parameters import plants

    plant, *between, controller = asked.names
    for name in asked.openings if plant in plants() else ():
        opening_among(name, openings_of(plants()[plant], "phases" if between else "dq"), f"{plant} with {controller}")
    asked.write(print_loop(asked, maglev.linearise_loop(
        plant, controller, asked.at, amplifier=amplifier, **asked.both, measurement=next(iter(between), None),
        measurement_parameters=asked.parameters["measurement"])))


def by_differences(asked: Asked) -> None:
    """Print poles and margins of the loop of any plant or controller, by differences of their responses."""
    plant, controller = asked.names
    numerical = maglev.linearise_numerically(plant, controller, asked.at, openings=asked.openings, **asked.both,
                                             **asked.how)
    if numerical.loop is None:
        typer.echo(f"{numerical.pair.name}\n\n{numerical}")
        asked.write({"name": numerical.pair.name, **numerical.as_data()})
        numerical.linear()   # says that there is none
        return
    data = print_loop(asked, numerical.loop)
    typer.echo(f"\n{numerical}")
    asked.write({**data, **numerical.as_data(),
                 "errors": {signal: numerical.errors(signal) for signal in data["margins"]}})


def print_measured(asked: Asked, amplitude: str, **injection: Any) -> None:
    """Print the frequency responses and margins of a loop, measured by injection."""
    plant, controller = asked.names
    responses = maglev.frequency_response(plant, controller, asked.at, asked.openings,
                                          amplitude=number_or_text(amplitude), **injection, **asked.both, **asked.how)
    typer.echo("\n".join(map(str, responses.values())), nl=False)
    data: dict[str, Any] = {signal: response.as_data() for signal, response in responses.items()}
    for signal, response in responses.items() if asked.pictures is not None else ():
        picture = Path(str(asked.pictures)) / f"{Path(plant).stem}-{Path(controller).stem}-{signal}.response.png"
        write_figure(picture, response.plot())
        data[signal]["picture"] = str(picture)
        typer.echo(f"picture: {picture}")
    asked.write(data)


def print_loop(asked: Asked, loop: "Loop") -> dict[str, Any]:
    """Print the poles and margins of a loop, write its pictures, and return them as data."""
    from maglev.files.text_columns import aligned
    from maglev.linear.model import poles_text

    signals = tuple(loop.opening(name) for name in asked.openings or loop.measured)
    typer.echo(f"{loop.closed.name}, sampled every {1e3 * (loop.plant.sample_time or 0.0):g} ms, about "
               f"{loop.plant.equilibrium}\n\npoles, as rates ln(z)/Ts\n{poles_text(loop.rates)}\n")
    of_signals = {signal: loop.margins(signal) for signal in signals}
    typer.echo(aligned([["opened at", "gain", "phase", "at", "delay", "Ms", "disk", "gain with phase"],
                        ["", "factor", "°", "rad/s", "ms", "", "", "factor, °"],
                        *(margin_cells(margins) for margins in of_signals.values())]))
    data = {"name": loop.closed.name, "sample_time": loop.plant.sample_time,
            "poles": [[pole.real, pole.imag] for pole in loop.poles.tolist()],
            "margins": {signal: vars(margins) for signal, margins in of_signals.items()}}
    return data if asked.pictures is None else {**data, "pictures": write_pictures(asked.pictures, loop, signals)}


def margin_cells(margins: "Margins") -> list[str]:
    low, high = margins.disk_gain
    return [margins.at, f"{margins.gain_down:.3g}…{margins.gain_up:.3g}", f"{degrees(margins.phase):.1f}",
            f"{margins.phase_frequency:.4g}", f"{1e3 * margins.delay:.3g}", f"{margins.sensitivity_peak:.3g}",
            f"{margins.disk:.3g}", f"{low:.2f}…{high:.2f}, {degrees(margins.disk_phase):.0f}°"]


def write_pictures(out: Path, loop: "Loop", signals: tuple[str, ...]) -> list[str]:
    """Write Bode and Nyquist pictures, and return their paths."""
    from maglev.linear.loop import write_bode, write_nyquist

    stem = f"{loop.plant.name}-{loop.controller.name}"
    bode, nyquist = out / f"{stem}.bode.png", out / f"{stem}.nyquist.png"
    write_bode(bode, loop, signals)
    write_nyquist(nyquist, loop, signals)
    typer.echo(f"pictures: {bode}, {nyquist}")
    return [str(bode), str(nyquist)]
