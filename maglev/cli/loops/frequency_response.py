"""The command `maglev frequency-response`."""

from pathlib import Path
from typing import Annotated, Any

import typer

from maglev.cli.loops.linearise import At, Parameters, SampleTime, Settle, pair, read_parameters, seconds
from maglev.cli.options import AsJson, Debug, Fmi, Fmus, Kind, Out, PortsFile, RigFile, Timeout
from maglev.cli.terminal import one_line_errors, write_json
from maglev.units import number_or_text

PlantName = Annotated[str, typer.Argument(metavar="PLANT", show_default=False,
                                          help="A plant, or the path of an FMU or a Python file.")]
ControllerName = Annotated[str, typer.Argument(metavar="CONTROLLER", show_default=False,
                                               help="A controller, or the path of an FMU or a Python file.")]
Openings = Annotated[list[str] | None, typer.Option(
    "--open", metavar="SIGNAL", help="Where to open the loop, one after the other: an axis or `y.measured`, a tilt, "
    "`alpha1.gap_measured`; every axis if not given.", show_default=False)]
Amplitude = Annotated[str, typer.Option(help="Peak of what is added to the measurement, in m, rad or with a unit.")]
Lowest = Annotated[float, typer.Option("--from", help="Lowest frequency, rad/s: a period takes 2π over it.")]
Highest = Annotated[float, typer.Option("--to", help="Highest frequency, rad/s.")]
Lines = Annotated[int, typer.Option(help="Frequencies, evenly over the logarithm as far as they are harmonics.")]
Realisations = Annotated[int, typer.Option(help="Multisines of other phases, by which the error is estimated.")]
Periods = Annotated[int, typer.Option(help="Periods that are recorded of each.")]
Smooth = Annotated[bool, typer.Option("--smooth", help="Without Coulomb friction and rounding of the encoders, as the "
                                      "linear model has it.")]
Linear = Annotated[bool, typer.Option("--linear/--no-linear", help="With or without the linear loop beside it.")]
Plot = Annotated[bool, typer.Option("--plot", help="Picture of each, over the linear loop (needs matplotlib).")]


def frequency_response(plant: PlantName, controller: ControllerName, at: At, openings: Openings = None,
                       amplitude: Amplitude = "100 um", lowest: Lowest = 1.0, highest: Highest = 2000.0,
                       lines: Lines = 48, realisations: Realisations = 3, periods: Periods = 2, smooth: Smooth = False,
                       linear: Linear = True, settings: Parameters = None, rig: RigFile = None,
                       ports: PortsFile = None, sample_time: SampleTime = None, settle: Settle = "10 s",
                       fmus: Fmus = None, kind: Kind = None, fmi: Fmi = 2,
                       timeout: Timeout = "60 s", plot: Plot = False, as_json: AsJson = None,
                       out: Out = Path("results"), debug: Debug = False) -> None:
    """Measure the frequency response of a loop as it flies, and its margins, by injection.

    Multisines are added to a measurement between plant and controller: the response of the loop opened there, with
    all that is not linear in it, coherence, margins with their standard errors, and the linear loop beside them where
    there is one. For laws that have no derivative, FMUs that hide what they are, and for what friction and encoders do.

    **Examples:**

    `maglev frequency-response Plant3DOF Regulator3DOF --at y=25mm --open y --plot`

    `maglev frequency-response Plant3DOF mine.py --at y=25mm --amplitude 0.3mm --from 3 --to 600`

    `maglev frequency-response Plant3DOF theirs.fmu --map ports.toml --at y=25mm --smooth --json theirs.json`
    """
    # numpy and scipy take their time to load: only who asks waits for them.
    from maglev.analysis.frequency_response import frequency_response as measured
    from maglev.pictures import require_matplotlib, write_figure

    with one_line_errors(debug):
        if plot:
            require_matplotlib()
        positions = {axis: number_or_text(value) for axis, value in (pair("--at", text) for text in at)}
        given = read_parameters(settings or [])
        found = measured(plant, controller, positions, openings or (), amplitude=number_or_text(amplitude),
                         lowest=lowest, highest=highest, lines=lines, realisations=realisations, periods=periods,
                         smooth=smooth, linear=linear, plant_parameters=given["plant"],
                         controller_parameters=given["controller"], rig=rig, ports=ports,
                         sample_time=None if sample_time is None else number_or_text(sample_time),
                         settle=seconds("settle", settle), fmus=fmus, kind=kind, fmi=fmi,
                         timeout=seconds("timeout", timeout))
        typer.echo("\n".join(str(each) for each in found.values()), nl=False)
        data: dict[str, Any] = {name: each.as_data() for name, each in found.items()}
        for name, each in found.items() if plot else ():
            picture = out / f"{Path(plant).stem}-{Path(controller).stem}-{name}.response.png"
            write_figure(picture, each.plot())
            data[name]["picture"] = str(picture)
            typer.echo(f"picture: {picture}")
        if as_json is not None:
            write_json(as_json, data)
