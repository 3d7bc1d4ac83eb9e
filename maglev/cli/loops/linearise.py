"""The command `maglev linearise`."""

from collections.abc import Mapping, Sequence
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from maglev.cli.options import Debug, Fmi, Fmus, Out, PortsFile, RigFile, Timeout
from maglev.cli.options import Kind as FmuKind
from maglev.cli.terminal import one_line_errors, write_json
from maglev.errors import LinearModelError
from maglev.units import number_or_text, positive_time

if TYPE_CHECKING:
    from maglev.linear.loop import Loop
    from maglev.linear.margins import Margins
    from maglev.linear.parameters import Quantity

Blocks = Annotated[list[str], typer.Argument(
    metavar="PLANT [CONTROLLER]", show_default=False, help="A plant, a controller, or a plant and a controller for "
    "their loop. In the loop each may be anybody's: the path of an FMU or a Python file.")]
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
Settle = Annotated[str, typer.Option(help="Longest time that a loop flies to its rest before it is looked at, in s "
                                     "or with a unit.")]
SampleTime = Annotated[str | None, typer.Option(
    "--sample-time", help="Sample time of a controller that is given as a file, in s or with a unit; its parameter "
    "sample_time, or the step in --map, if not given.", show_default=False)]
AsJson = Annotated[Path | None, typer.Option(
    "--json", metavar="FILE", help="Also write the model, or poles and margins of the loop, as JSON.",
    show_default=False)]


def linearise(names: Blocks, at: At, currents: Kind = "dq", amplifier: Amplifier = True, hold: Hold = None,
              forces: Forces = False, settings: Parameters = None, openings: Openings = None, rig: RigFile = None,
              ports: PortsFile = None, sample_time: SampleTime = None, settle: Settle = "10 s",
              fmus: Fmus = None, kind: FmuKind = None, fmi: Fmi = 2, timeout: Timeout = "60 s",
              plot: Plot = False, as_json: AsJson = None, out: Out = Path("results"), debug: Debug = False) -> None:
    """Linearise a plant, a controller, or the loop of both about an equilibrium.

    The plants and controllers of this project from their equations; an FMU or a Python file by differences of what it
    does where its loop rests, with an estimate of the error, and the sentence that it has no derivative where it has
    none (`maglev frequency-response` measures such a loop).

    **Examples:**

    `maglev linearise Plant3DOF --at y=25mm` prints A, B, C, D, the currents of the equilibrium and the poles

    `maglev linearise Plant3DOF --at y=25mm --currents phases --no-amplifier --hold 0.2ms --set plant.y.mass=7.2kg`

    `maglev linearise PlantMine RegulatorMine --at y=25mm --rig mine.toml` of a stage of yours

    `maglev linearise Plant3DOF Regulator3DOF --at y=25mm --open y --open alpha.i_q --plot` prints poles and margins

    `maglev linearise Plant5DOF Regulator5DOF --at y=25mm --at roll=3mrad --open roll --open alpha1.gap_measured`

    `maglev linearise Plant3DOF mine.py --at y=25mm --plot` of a controller of yours, a Python file or an FMU
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
            if any(is_file(name) for name in names):
                if not amplifier:
                    raise LinearModelError("--no-amplifier: expected no file with it, whose loop flies as it is")
                show_numerical(names, positions, given, openings or (), out if plot else None, as_json,
                               {"rig": rig, "ports": ports, "fmus": fmus, "kind": kind, "fmi": fmi,
                                "sample_time": None if sample_time is None else number_or_text(sample_time),
                                "settle": seconds("settle", settle), "timeout": seconds("timeout", timeout)})
                return
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


def is_file(name: str) -> bool:
    """Whether a name is the path of an FMU or of a Python file."""
    return name.endswith((".fmu", ".py")) or ".py:" in name


def seconds(name: str, text: str) -> float:
    """A time above 0, s, as an option has it."""
    return positive_time(text, LinearModelError, f"--{name} {text}")


def show_numerical(names: Sequence[str], at: Mapping[str, "Quantity"], given: Mapping[str, "dict[str, Any]"],
                   openings: Sequence[str], pictures: Path | None, as_json: Path | None,
                   options: Mapping[str, Any]) -> None:
    """Print the loop of anybody's plant or controller, write its pictures and its JSON."""
    from maglev.analysis.numerical import linearise_numerically
    from maglev.pictures import require_matplotlib

    if pictures is not None:
        require_matplotlib()
    found = linearise_numerically(names[0], names[1], at, plant_parameters=given["plant"],
                                  controller_parameters=given["controller"], **options)
    if found.loop is None:
        typer.echo(f"{found.pair.name}\n\n{found}")
        if as_json is not None:
            write_json(as_json, {"name": found.pair.name, **found.as_data()})
        found.linear()
        return
    signals = tuple(found.loop.opening(name) for name in openings or found.loop.measured)
    data = {**show(found.loop, signals), **found.as_data(),
            "errors": {signal: found.errors(signal) for signal in signals}}
    typer.echo(f"\n{found}")
    if pictures is not None:
        data["pictures"] = write_pictures(pictures, found.loop, signals)
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
    typer.echo(aligned([["opened at", "gain", "phase", "at", "delay", "Ms", "disk", "gain with phase"],
                        ["", "factor", "°", "rad/s", "ms", "", "", "factor, °"],
                        *(row(margins) for margins in found.values())]))
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
