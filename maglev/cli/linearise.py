"""The command `maglev linearise`."""

from collections.abc import Mapping, Sequence
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from maglev.cli.options import Debug, Out, RigFile
from maglev.cli.terminal import one_line_errors, write_json
from maglev.errors import LinearModelError
from maglev.units import number_or_text

if TYPE_CHECKING:
    from maglev.linear.loop import Loop
    from maglev.linear.margins import Margins

Blocks = Annotated[list[str], typer.Argument(metavar="PLANT [CONTROLLER]", show_default=False,
                                             help="A plant, a controller, or a plant and a controller for their loop.")]
At = Annotated[list[str], typer.Option(
    "--at", metavar="AXIS=POSITION", help="Where to linearise, m, rad or with a unit: the gap `v` or `y`, and other "
    "axes that are not at 0.", show_default=False)]
Kind = Annotated[str, typer.Option("--currents", help="Inputs of a plant, outputs of a controller: `dq` or `phases`.")]
Amplifier = Annotated[bool, typer.Option("--amplifier/--no-amplifier", help="With or without the amplifiers' lag.")]
Hold = Annotated[str | None, typer.Option(help="Sample time of a plant whose inputs are held, in s or with a unit.",
                                          show_default=False)]
Forces = Annotated[bool, typer.Option("--forces", help="External forces are inputs of the plant, too.")]
Parameters = Annotated[list[str] | None, typer.Option(
    "--set", metavar="plant.variable=value", help="Parameter of `plant` or `controller`; may carry a unit and may be "
    "repeated.", show_default=False)]
Openings = Annotated[list[str] | None, typer.Option(
    "--open", metavar="SIGNAL", help="Where to open the loop: an axis or `y.measured`, with all that takes the "
    "measurement, or `alpha.i_q_cmd`; a tilt is opened in the gaps at all motors, `alpha1.gap_measured` alone; every "
    "axis if not given.", show_default=False)]
Plot = Annotated[bool, typer.Option("--plot", help="Bode and Nyquist pictures of the loop (needs matplotlib).")]
AsJson = Annotated[Path | None, typer.Option(
    "--json", metavar="FILE", help="Also write the model, or poles and margins of the loop, as JSON.",
    show_default=False)]


def linearise(names: Blocks, at: At, currents: Kind = "dq", amplifier: Amplifier = True, hold: Hold = None,
              forces: Forces = False, settings: Parameters = None, openings: Openings = None, rig: RigFile = None,
              plot: Plot = False, as_json: AsJson = None, out: Out = Path("results"), debug: Debug = False) -> None:
    """Linearise a plant, a controller, or the loop of both about an equilibrium.

    **Examples:**

    `maglev linearise Plant3DOF --at y=25mm` prints A, B, C, D, the currents of the equilibrium and the poles

    `maglev linearise Plant3DOF --at y=25mm --currents phases --no-amplifier --hold 0.2ms --set plant.y.mass=7.2kg`

    `maglev linearise PlantMine RegulatorMine --at y=25mm --rig mine.toml` of a stage of yours

    `maglev linearise Plant3DOF Regulator3DOF --at y=25mm --open y --open alpha.i_q --plot` prints poles and margins

    `maglev linearise Plant5DOF Regulator5DOF --at y=25mm --at roll=3mrad --open roll --open alpha1.gap_measured`
    """
    # numpy and scipy take their time to load: only who linearises waits for them.
    from maglev.linear.linearise import linearise as linearised
    from maglev.linear.loop import linearise_loop
    from maglev.linear.parameters import CONTROLLERS
    from maglev.own_stage.adoption import know_stage

    with one_line_errors(debug):
        if rig is not None:
            know_stage(rig)
        positions = {axis: number_or_text(value) for axis, value in (pair("--at", text) for text in at)}
        given = read_parameters(settings or [])
        if len(names) == 1:
            if openings or plot:
                raise LinearModelError("--open and --plot are for loops, expected a plant and a controller")
            # No option says what is in the model of a controller: those of a plant are refused by `linearise`.
            other, own = ("plant", "controller") if names[0] in CONTROLLERS else ("controller", "plant")
            if given[other]:
                raise LinearModelError(f"--set {other}.{next(iter(given[other]))}: expected {own}.… with {names[0]}")
            model = linearised(names[0], positions, currents=currents, amplifier=amplifier,   # type: ignore[arg-type]
                               hold=None if hold is None else number_or_text(hold), forces=forces,
                               parameters=given[own])
            typer.echo(str(model), nl=False)
            data = model.as_data()
        elif len(names) == 2:
            if hold is not None or forces or currents != "dq":
                raise LinearModelError("--hold, --forces and --currents are for one model, expected none with a loop")
            loop = linearise_loop(names[0], names[1], positions, amplifier=amplifier,
                                  plant_parameters=given["plant"], controller_parameters=given["controller"])
            signals = tuple(loop.opening(name) for name in openings or loop.measured)
            data = show(loop, signals)
            if plot:
                data["pictures"] = write_pictures(out, loop, signals)
        else:
            raise LinearModelError(f"{len(names)} names, expected a plant, a controller, or a plant and a controller")
        if as_json is not None:
            write_json(as_json, data)


def pair(option: str, text: str) -> tuple[str, str]:
    """Name and value of `name=value`, as an option has it."""
    name, equals, value = text.partition("=")
    if not (name.strip() and equals and value.strip()):
        raise LinearModelError(f"{option} {text}: expected a name, = and a value with its unit, such as y=25mm")
    return name.strip(), value.strip()


def read_parameters(settings: Sequence[str]) -> Mapping[str, dict[str, float | str | bool]]:
    """Parameters of plant and controller from the options --set."""
    found: dict[str, dict[str, float | str | bool]] = {"plant": {}, "controller": {}}
    for text in settings:
        name, value = pair("--set", text)
        part, dot, variable = name.partition(".")
        if part not in found or not dot:
            raise LinearModelError(f"--set {text}: expected plant.… or controller.…, such as plant.y.mass=7.2kg")
        found[part][variable] = value == "true" if value in ("true", "false") else number_or_text(value)
    return found


def show(loop: "Loop", signals: Sequence[str]) -> dict[str, object]:
    """Print the poles and margins of a loop, and return them as data."""
    from maglev.linear.text import aligned, poles_text

    typer.echo(f"{loop.closed.name}, sampled every {1e3 * (loop.plant.sample_time or 0.0):g} ms, about "
               f"{loop.plant.equilibrium}\n\npoles, as rates ln(z)/Ts\n{poles_text(loop.rates)}\n")
    found = {signal: loop.margins(signal) for signal in signals}
    typer.echo(aligned([["opened at", "gain factor", "phase (°)", "at (rad/s)", "delay (ms)", "Ms", "disk",
                         "gain and phase together"], *(row(margins) for margins in found.values())]))
    return {"name": loop.closed.name, "sample_time": loop.plant.sample_time,
            "poles": [[pole.real, pole.imag] for pole in loop.poles.tolist()],
            "margins": {signal: vars(margins) for signal, margins in found.items()}}


def row(margins: "Margins") -> list[str]:
    """Cells of one opening."""
    low, high = margins.disk_gain
    return [margins.at, f"{margins.gain_down:.3g}…{margins.gain_up:.3g}", f"{degrees(margins.phase):.1f}",
            f"{margins.phase_frequency:.4g}", f"{1e3 * margins.delay:.3g}", f"{margins.sensitivity_peak:.3g}",
            f"{margins.disk:.3g}", f"{low:.2f}…{high:.2f}, {degrees(margins.disk_phase):.0f}°"]


def write_pictures(out: Path, loop: "Loop", signals: tuple[str, ...]) -> list[str]:
    """Write Bode and Nyquist pictures, and return their paths."""
    from maglev.linear.pictures import write_bode, write_nyquist

    stem = f"{loop.plant.name}-{loop.controller.name}"
    bode, nyquist = out / f"{stem}.bode.png", out / f"{stem}.nyquist.png"
    write_bode(bode, loop, signals)
    write_nyquist(nyquist, loop, signals)
    typer.echo(f"pictures: {bode}, {nyquist}")
    return [str(bode), str(nyquist)]
