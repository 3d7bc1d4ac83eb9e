"""The command `maglev region`."""

from pathlib import Path
from typing import Annotated, Any

import typer

import maglev
from maglev.cli.options import AXIS_NAMES, STAGE_NAMES, VALUE, AsJson, Debug, Out, option_value, pairs, with_run_options
from maglev.cli.terminal import one_line_errors, write_json
from maglev.files.errors import LinearModelError
from maglev.files.pictures import require_matplotlib, write_figure
from maglev.files.units import number_or_text

StageName = Annotated[str,
                      typer.Argument(metavar="DESCRIPTION", help=f"{STAGE_NAMES}, or a TOML file.", show_default=False)]
Axis = Annotated[str, typer.Argument(metavar="AXIS", help=f"{AXIS_NAMES}.", show_default=False)]
Gap = Annotated[str, typer.Option(help="Air gap at which all else rests, in m or with a unit.", show_default=False)]
Regulator = Annotated[str | None, typer.Option(help="An output regulator; the nonlinear one if not given.",
                                               show_default=False)]
Parameters = Annotated[list[str] | None, typer.Option(
    "--set", metavar="controller.variable=value", help="Parameter of `controller` or `plant`; may carry a unit and may "
    "be repeated.", show_default=False)]
Synthesise = Annotated[bool, typer.Option("--synthesise", help="Also look for the anti-windup gains with the largest "
                                          "certified step.")]
Decay = Annotated[float, typer.Option(help="Rate at which states in the ellipsoid decay with these, 1/s.")]
Step = Annotated[str | None, typer.Option(help="Step of the responses, in m or with a unit; the largest certified one "
                                          "if not given.", show_default=False)]
Run = Annotated[bool, typer.Option("--run/--no-run", help="Run steps with the FMUs, next to what is certified; with "
                                   "native ones it takes seconds, with Python ones a minute or two.")]
Plot = Annotated[bool, typer.Option("--plot", help="Picture of the region and the responses (needs matplotlib).")]


@with_run_options("fmus", "kind", "fmi")
def region(stage: StageName, axis: Axis, gap: Gap, controller: Regulator = None, settings: Parameters = None,
           synthesise: Synthesise = False, decay: Decay = 1.0, step: Step = None, run: Run = True, plot: Plot = False,
           as_json: AsJson = None, out: Out = Path("results"), debug: Debug = False, **options: Any) -> None:
    """Find the largest step that an axis takes although currents are limited.

    Certified by linear matrix inequalities for the linear loop, and held by the FMUs, which have the friction, the
    stops and the moving gap that a certificate leaves out (needs the extra `region`).

    **Examples:**

    `maglev region 3dof x --gap 25mm --plot`

    `maglev region 3dof x --gap 25mm --synthesise --decay 0.5 --no-run --json x.json`

    `maglev region 3dof z --gap 25mm --set controller.z.ec1=2e-4 --step 20mm`
    """
    with one_line_errors(debug):
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
