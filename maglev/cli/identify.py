"""The command `maglev identify`: constants of a stage from a person's own recording."""

from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

import maglev
from maglev.cli.options import ANY_STAGE, MORE, Debug, Out, pairs
from maglev.cli.terminal import one_line_errors, report_console
from maglev.files.errors import IdentificationError
from maglev.identification.settings import EPSILON, GAMMA

if TYPE_CHECKING:
    from rich.console import Console

    from maglev.files.table_times import Gaps
    from maglev.identification.identify import Identification

ERRORS = ("The standard error is the scatter between recordings. The bias is the same in every recording: the shift by "
          "friction, bias, ripple and modulation as described, and its upper bound. "
          "An estimate may be off by two standard errors plus the bias.")

Data = Annotated[Path, typer.Argument(metavar="DATA.csv", help="The recording.", show_default=False)]
StageName = Annotated[str | None, typer.Option(
    "--stage", metavar="STAGE", help=ANY_STAGE, show_default=False)]
Method = Annotated[str, typer.Option(metavar="METHOD", help="`reduced`, `full` or `fsdi`.")]
Epsilon = Annotated[str, typer.Option(metavar="TIME", help="Confidence level ε.", rich_help_panel=MORE)]
Gamma = Annotated[float, typer.Option(metavar="X", help="Attenuation γ, above 1.", rich_help_panel=MORE)]
Columns = Annotated[list[str] | None, typer.Option(
    "--column", metavar="v=NAME", help="Name of a column in the recording. Repeatable.", show_default=False)]
Units = Annotated[list[str] | None, typer.Option(
    "--unit", metavar="v=mm", help="Unit of a column without one. Repeatable.", show_default=False)]
GapsChoice = Annotated[str, typer.Option(
    "--gaps", metavar="WAY", help="On gaps: `refuse`, `fill` or `longest`.")]
Guesses = Annotated[list[str] | None, typer.Option(
    "--guess", metavar="C1=VALUE", help="Initial value of a constant. Repeatable.", show_default=False)]
Matched = Annotated[bool, typer.Option("--matched", help="Filter positions and currents like the velocity.")]


def identify(data: Data, stage: StageName = None, column: Columns = None, unit: Units = None,
             gaps: GapsChoice = "refuse", method: Method = "reduced", epsilon: Epsilon = str(EPSILON),
             gamma: Gamma = GAMMA, guess: Guesses = None, matched: Matched = False, out: Out = Path("results"),
             debug: Debug = False) -> None:
    """Identify the constants of a stage from recorded data.

    The CSV has columns `time` (s), the positions `v`, `h` or `y`, `x`, `z` (m), and the currents `i_d`, `i_q` or `i_a`,
    `i_b`, `i_c` (A), as `alpha.i_d` with two motors. Semicolons, decimal commas, units as in `v [mm]` and time
    stamps are read, too; a line says what was assumed.

    Identify from a recorded run, and run again with the result:

        maglev run 2dof-identification-rig
        maglev identify results/2dof-identification-rig.csv --matched
        maglev run 2dof-setpoints \\
            --model results/2dof-identification-rig.identified.toml

    `--gaps` decides on uneven times: refuse them, fill them with straight lines, or use the longest part without. The
    methods are those of (3.8), (3.6) and (3.3).

    The results are `NAME.identified.toml` and `NAME.convergence.csv`, with a picture.
    """
    with one_line_errors(debug):
        guesses = dict(pairs("--guess", guess, "a constant and a value, such as C1=10", IdentificationError))
        columns = dict(pairs("--column", column, "a column and its name, such as v=gap", IdentificationError))
        units = dict(pairs("--unit", unit, "a column and its unit, such as v=mm", IdentificationError))
        model = maglev.identify(data, stage=stage, columns=columns, units=units, gaps=cast("Gaps", gaps), method=method,
                                epsilon=epsilon, gamma=gamma, guess=guesses, matched=matched)
        files = maglev.write_identification(model, data, out)
        show(report_console(), model)
        typer.echo(f"results: {', '.join(map(str, files))}")


def show(console: "Console", model: "Identification") -> None:
    """Print constants, rows and warnings."""
    from maglev.files.console import ResultTable
    from maglev.identification.identify import HORIZON

    recording, estimate = model.recording, model.estimate
    length = recording.time[-1] - recording.time[0]
    console.print(f"{recording.stage.name}: {len(recording.time)} samples over {length:.3g} s, "
                  f"{estimate.method} estimator, ε = {estimate.epsilon:g} s, γ = {estimate.gamma:g}"
                  f"{', matched filters' if model.matched else ''}")
    rows = []
    for name, value in estimate.final.items():
        other = model.with_friction[name]
        shares = [f"{error:{sign}.2g} ({error / abs(value):{sign}.1%})" if value != 0.0 and isfinite(error) else "–"
                  for error, sign in ((model.standard_error[name], ""), (model.bias[name], "+"),
                                      (model.left_out[name], ""))]
        rows.append([name, f"{model.guess[name]:.5g}", f"{value:.5g}", *shares,
                     f"{other:.5g}" if other == other else "–"])
    heads = ("constant", "guess", "estimate", "standard error", "bias", "at most", "with friction")
    console.print(ResultTable("", heads, rows))
    console.print(ERRORS)
    rows = []
    axes = recording.stage.described.axes
    for axis, error, way in zip(axes, model.replay_error, model.replay_motion, strict=True):
        row, unit = model.diagnostics.get(axis.name), f"m{axis.unit('m')}"   # tilts have no row of constants
        known = ["–"] * 3 if row is None else [f"{row.excitation[-1]:.3g}", f"{row.residual:.3g} m/s²",
                                               f"{row.motion:.3g} m/s²"]
        rows.append([axis.name, *known, f"{1e3 * error:.3g} {unit}", f"{1e3 * way:.3g} {unit}"])
    console.print(ResultTable("", ("axis", "excitation", "unexplained", "acceleration",
                                   f"replay over {1e3 * HORIZON:g} ms", "way"), rows))
    for warning in model.warnings:
        console.print(f"warning: {warning}", soft_wrap=True)
