"""The command `maglev identify`: constants of a stage from a person's own recording."""

from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

import maglev
from maglev.cli.options import STAGE_NAMES, Debug, Out, pairs
from maglev.cli.terminal import one_line_errors, report_console
from maglev.files.errors import IdentificationError
from maglev.identification.settings import EPSILON, GAMMA

if TYPE_CHECKING:
    from rich.console import Console

    from maglev.files.table_times import Gaps
    from maglev.identification.identify import Identification

ERRORS = ("The standard error is the scatter from one recording to another. The bias is what every recording repeats: "
          "what friction, bias, ripple and modulation as described change in the estimate, and could at most. "
          "An estimate may be off by two standard errors and the bias at most.")

Data = Annotated[Path, typer.Argument(metavar="DATA.csv", help="The recording.", show_default=False)]
StageName = Annotated[str | None, typer.Option(
    "--stage", help=f"{STAGE_NAMES}, seen from the columns if not given; or a description of yours, `mine.toml`.",
    show_default=False)]
Method = Annotated[str, typer.Option(help="`reduced` (3.8), `full` (3.6) or `fsdi` (3.3).")]
Epsilon = Annotated[str, typer.Option(help="Confidence level ε of the measurement, in s or with a unit.")]
Gamma = Annotated[float, typer.Option(help="Attenuation γ, more than 1.")]
Columns = Annotated[list[str] | None, typer.Option(
    "--column", metavar="v=NAME", help="What the recording calls a column; may be repeated.", show_default=False)]
Units = Annotated[list[str] | None, typer.Option(
    "--unit", metavar="v=mm", help="Unit of a column whose header says none; may be repeated.", show_default=False)]
GapsChoice = Annotated[str, typer.Option("--gaps", help="Where times are uneven by more than 5 %: `refuse`, `fill` by "
                                         "straight lines, or use the `longest` part without.")]
Guesses = Annotated[list[str] | None, typer.Option(
    "--guess", metavar="C1=value", help="Initial value of a constant; may be repeated.", show_default=False)]
Matched = Annotated[bool, typer.Option("--matched", help="Filter positions and currents as the observer filters the "
                                       "velocity: more accurate thrust constants.")]


def identify(data: Data, stage: StageName = None, column: Columns = None, unit: Units = None,
             gaps: GapsChoice = "refuse", method: Method = "reduced", epsilon: Epsilon = str(EPSILON),
             gamma: Gamma = GAMMA, guess: Guesses = None, matched: Matched = False, out: Out = Path("results"),
             debug: Debug = False) -> None:
    """Identify the constants of a stage from recorded data.

    The CSV has columns `time` (s), the positions `v`, `h` or `y`, `x`, `z` (m) and the delivered currents `i_d`, `i_q`
    or `i_a`, `i_b`, `i_c` (A; `alpha.i_d`, `beta.i_d` … where there are two motors). Results of `maglev run` will do.
    So does what laboratories write, with semicolons or tabs, decimal commas, units as in `v [mm]`, or time stamps: it
    takes the extra `data`, and a line says what was assumed.

    **Examples:** `maglev identify my_recording.csv --matched`, `maglev identify results/2dof-identification-rig.csv
    --guess C1=10`

    The results are `NAME.identified.toml`, for `maglev run --model`, and `NAME.convergence.csv` with a picture of it.
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
    from maglev.files.console import result_table
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
    console.print(result_table("", heads, rows))
    console.print(ERRORS)
    rows = []
    axes = recording.stage.described.axes
    for axis, error, way in zip(axes, model.replay_error, model.replay_motion, strict=True):
        row, unit = model.diagnostics.get(axis.name), f"m{axis.unit('m')}"   # tilts have no row of constants
        known = ["–"] * 3 if row is None else [f"{row.excitation[-1]:.3g}", f"{row.residual:.3g} m/s²",
                                               f"{row.motion:.3g} m/s²"]
        rows.append([axis.name, *known, f"{1e3 * error:.3g} {unit}", f"{1e3 * way:.3g} {unit}"])
    console.print(result_table("", ("axis", "excitation", "unexplained", "acceleration",
                                    f"replay over {1e3 * HORIZON:g} ms", "way"), rows))
    for warning in model.warnings:
        console.print(f"warning: {warning}", soft_wrap=True)
