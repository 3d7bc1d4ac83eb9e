"""The command `maglev region`."""

from pathlib import Path
from typing import Annotated, Any

import typer

import maglev
from maglev.cli.options import (
    ANY_STAGE,
    MORE,
    VALUE,
    AsJson,
    Debug,
    Out,
    option_value,
    pairs,
    with_run_options,
)
from maglev.cli.terminal import one_line_errors, write_json
from maglev.files.errors import LinearModelError
from maglev.scenario.options import FmuOptions

StageName = Annotated[str, typer.Argument(metavar="STAGE", help=ANY_STAGE, show_default=False)]
Axis = Annotated[str, typer.Argument(metavar="AXIS", help="An axis of the stage, such as `x`.", show_default=False)]
Gap = Annotated[str, typer.Option(metavar="LENGTH", help="Air gap, in m or with a unit.", show_default=False)]
Regulator = Annotated[str | None, typer.Option(metavar="NAME", help="Output regulator; default: the nonlinear one.",
                                               show_default=False)]
Parameters = Annotated[list[str] | None, typer.Option(
    "--set", metavar="FMU.VARIABLE=VALUE", help="Parameter in SI or with a unit. Repeatable.", show_default=False)]
Synthesise = Annotated[bool, typer.Option("--synthesise", help="Also search anti-windup gains.")]
Decay = Annotated[float, typer.Option(metavar="RATE", help="Decay rate with these gains, 1/s.", rich_help_panel=MORE)]
Step = Annotated[str | None, typer.Option(metavar="LENGTH", help="Step to plot; default: the largest certified.",
                                          show_default=False, rich_help_panel=MORE)]
Run = Annotated[bool, typer.Option("--run/--no-run", help="Also run steps with the FMUs.", show_default=False)]
Plot = Annotated[bool, typer.Option("--plot", help="Draw region and responses (needs matplotlib).")]


@with_run_options(FmuOptions.__annotations__)
def region(stage: StageName, axis: Axis, gap: Gap, controller: Regulator = None, settings: Parameters = None,
           synthesise: Synthesise = False, decay: Decay = 1.0, step: Step = None, run: Run = True, plot: Plot = False,
           as_json: AsJson = None, out: Out = Path("results"), debug: Debug = False, **options: Any) -> None:
    """Find the largest step of an axis with limited currents.

    Linear matrix inequalities certify a step for the linear loop. Runs of the FMUs then find the largest step with
    friction, stops and a moving gap, which the certificate leaves out. Needs the extra `region`.

    Compute and draw the region of an axis:

        maglev region 3dof x --gap 25mm --plot

    Search anti-windup gains, without runs, and write the results as JSON:

        maglev region 3dof x --gap 25mm --synthesise --no-run --json x.json

    Change a limit, and plot a given step:

        maglev region 3dof z --gap 25mm --set controller.z.ec1=2e-4 --step 20mm
    """
    with one_line_errors(debug):
        from maglev.files.pictures import require_matplotlib, write_figure
        from maglev.files.units import number_or_text

        if plot:
            require_matplotlib()
        given = {name: option_value(text) for name, text in pairs("--set", settings, VALUE, LinearModelError)}
        computed = maglev.region(stage, axis, number_or_text(gap), controller=controller, set=given,
                                 synthesise=synthesise, decay=decay,
                                 step=None if step is None else number_or_text(step), run=run, **options)
        typer.echo(str(computed), nl=False)
        if plot:
            picture = out / f"region-{Path(stage).stem}-{axis}.png"
            write_figure(picture, computed.plot())
            typer.echo(f"picture: {picture}")
        if as_json is not None:
            write_json(as_json, computed.as_data())
