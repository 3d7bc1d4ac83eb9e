"""The command line `maglev`: options and output; the work is done in `maglev.api`."""

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

import maglev
from maglev.cli.check import check
from maglev.cli.hand_on import cache, pack, target
from maglev.cli.identify import identify
from maglev.cli.linearise import linearise
from maglev.cli.listing import list_all
from maglev.cli.new import new, stage
from maglev.cli.options import (
    MORE,
    All,
    Built,
    Claims,
    Debug,
    Every,
    Form,
    Jobs,
    Names,
    Out,
    StageFile,
    run_names,
    with_run_options,
)
from maglev.cli.region import region
from maglev.cli.streams import CommandLine, Commands
from maglev.cli.study import compare, study, tune
from maglev.cli.terminal import one_line_errors, progress_of, require_environment, run_and_print, say
from maglev.files.errors import ScenarioError
from maglev.scenario.options import KindName

# One paragraph for each line: the help joins the lines of a paragraph.
app = CommandLine(cls=Commands, no_args_is_help=True, rich_markup_mode="markdown",
                  context_settings={"help_option_names": ["-h", "--help"]}, help="""
Simulate magnetically levitated stages with their controllers, as FMUs of FMI 2.0 and 3.0.

`maglev run 3dof-setpoints --open`: run a scenario, and open its page

`maglev list`: the scenarios, and the FMUs

`maglev new controller mine.py`: write a controller to change

`maglev run 3dof-setpoints --controller mine.py`: run a scenario with it

`maglev report`: run every scenario of the thesis, and write one page about its claims

Exit codes: 0 done; 1 a check deviates or, with `--fail-on-claims`, a claim is missed or a run failed (touched a stop,
tripped or ended too far off); 2 an error, or a run did not complete (reach its stop time); 130 after Ctrl-C, 141 if the
output was cut off, 143 after SIGTERM. One line says what went wrong.
""")


def print_version(asked: bool) -> None:
    if asked:
        typer.echo(f"maglev {maglev.__version__}")
        raise typer.Exit


@app.callback()
def main(_version: Annotated[bool, typer.Option("--version", callback=print_version, is_eager=True,
                                                help="Show the version and exit.")] = False) -> None:
    """Read the options before a command."""
    require_environment()


def build(names: Annotated[list[str] | None, typer.Argument(help="FMUs to build, all if none is named; or "
                                                            "Python files, each with your controller.",
                                                            show_default=False)] = None,
          stage: StageFile = None, fmus: Built = Path("fmus"),
          kind: Annotated[KindName, typer.Option("--kind", help="`native`: FMUs that need no Python, into the "
                                                 "subfolder native; needs the extra `native`.")] = "python",
          fmi: Annotated[int, typer.Option("--fmi", min=2, max=3, help="Version of FMI, of native FMUs; those of "
                                           "FMI 3.0 go into the subfolder fmi3.")] = 2,
          clocked: Annotated[bool, typer.Option("--clocked", help="With --fmi 3: FMUs that sample when a clock of "
                                                "the importer ticks; into the subfolder clocked.")] = False,
          target: Annotated[str, typer.Option(help="Of native FMUs: `all`, binaries for Linux, Windows and macOS; "
                                              "`host`, one for this machine; `wasm`, WebAssembly modules for "
                                              "browsers, into the subfolder wasm.")] = "all",
          source: Annotated[Path | None, typer.Option("--from", help="With --kind native: archive of native FMUs of a "
                                                      "release, or the folder that it was unpacked to; they are "
                                                      "copied, without a compiler.", show_default=False)] = None,
          ssp: Annotated[str | None, typer.Option("--ssp", metavar="SCENARIO", help="A run, whose FMUs and connections "
                                                  "become one file NAME.ssp.", show_default=False,
                                                  autocompletion=run_names)] = None,
          debug: Debug = False) -> None:
    """Build FMUs for other tools.

    Of this project, of your controller or of your stage. The same sources give the same bytes. Runs need no such build:
    they build what they need.

    **Examples:**

    `maglev build lqi.py`

    `maglev build --stage mine.toml`: those of your own stage, which `maglev new stage mine.toml` wrote

    `maglev build Plant3DOF Regulator3DOF`

    `maglev build --kind native`

    `maglev build --kind native ClosedLoop3DOF`

    `maglev build --kind native --fmi 3`

    `maglev build --kind native --from maglev-fmus-0.1.0-native.zip`: without a compiler

    `maglev build --ssp 3dof-thrust-loss-loose`
    """
    with one_line_errors(debug):
        with progress_of(["FMUs"]) as watch:
            paths = maglev.build(names or (), stage=stage, fmus=fmus, kind=kind, fmi=fmi, target=target,
                                 source=source, clocked=clocked, ssp=ssp, say=say, watch=partial(watch, "FMUs"))
        for path in paths:
            typer.echo(f"{path}  {path.stat().st_size / 1000:.0f} kB")


@with_run_options()
def run(names: Names = None, everything: All = False, out: Out = Path("results"),
        open_page: Annotated[bool, typer.Option("--open", help="Write the page of the run, and open it in the browser."
                                                )] = False,
        plot: Annotated[bool, typer.Option("--plot", help="Also write pictures (needs matplotlib).")] = False,
        fail_on_claims: Annotated[bool, typer.Option(
            "--fail-on-claims", help="Exit with 1 if a claim is missed, or a run failed: it touched a stop, "
                                       "tripped or ended too far off.")] = False,
        claims: Claims = None, form: Form = "csv", every: Every = None,
        json: Annotated[bool, typer.Option("--json", help="Print what was measured, verdicts and provenance as JSON.",
                                           rich_help_panel=MORE)] = False,
        jobs: Jobs = None, debug: Debug = False, **options: Any) -> None:
    """Run scenarios, and judge the claims about them.

    **Examples:**

    `maglev run 3dof-setpoints --set plant.y.mass=7.2kg --plot`

    `maglev run 2dof-setpoints --controller my_controller.fmu --map ports.toml --set controller.gain=3`

    `maglev run 3dof-setpoints --controller lqi.py --open` takes a class in Python: `maglev new controller lqi.py`

    `maglev run 2dof-step-4` runs all its variants, `maglev run 2dof-step-4-linear` one of them

    `maglev run mine.toml --controller lqi.py --fail-on-claims` holds a controller to the claims of mine.toml, for CI

    The results are `NAME.csv` or `NAME.parquet` (time first, then `fmu.variable`), `NAME.json` (provenance and
    metrics), `NAME.txt` and, of runs with claims, `claims.md`. A run that an FMU ends early leaves its columns in
    `NAME.partial.csv`. Runs that claims compare with are run as well. The outcome of a procedure of several runs is in
    `PROCEDURE.txt`, its curves in `PROCEDURE.curves.csv`.
    """
    with one_line_errors(debug):
        if everything == bool(names):
            raise ScenarioError("expected the name of a scenario, or --all" if not names else
                                f"--all and {', '.join(names)}: expected one of them")
        run_and_print(names, json=json, debug=debug, fail_on_claims=fail_on_claims, open_page=open_page, out=out,
                      plot=plot, page=open_page and "run", claims=claims, format=form, every=every,
                      jobs=jobs, **options)


@with_run_options()
def report(names: Names = None, out: Out = Path("results"),
           open_page: Annotated[bool, typer.Option("--open", help="Open the page in the browser.")] = False,
           what_if: Annotated[bool, typer.Option(help="Run again, without friction, what is behind missed claims whose "
                                                      "reasons blame it.")] = True,
           claims: Claims = None, jobs: Jobs = None, debug: Debug = False, **options: Any) -> None:
    """Run scenarios, all if none is named, and write one page about them.

    The page `report.html` needs no network: figures as in the thesis, to zoom into, the claims with their verdicts, and
    a moving picture of the stage.

    **Examples:**

    `maglev report`

    `maglev report 3dof-setpoints --controller my_controller.fmu`
    """
    with one_line_errors(debug):
        run_and_print(names, debug=debug, open_page=open_page, out=out, page=True, what_if=what_if, claims=claims,
                      jobs=jobs, **options)


@with_run_options("fmus")
def live(files: Annotated[list[str] | None, typer.Argument(
             metavar="FILE", help="Descriptions of stages of yours, or scenarios, instead of all packaged runs.",
             show_default=False)] = None,
         out: Out = Path("results"), debug: Debug = False, **options: Any) -> None:
    """Write the page `live.html`, which runs the stages in a browser.

    Drag, kick, change parameters, swap controllers. It needs no network and nothing installed. The FMUs in it are
    WebAssembly; those that are missing are built, which needs the extra `native`.

    **Examples:**

    `maglev live --out page`

    `maglev live mine.toml mine-setpoints.toml` writes `live-mine.html`
    """
    with one_line_errors(debug):
        path = maglev.write_live(out, files=files or (), say=say, watch=progress_of, **options)
        typer.echo(f"{path}  {path.stat().st_size / 1000:.0f} kB")


# In the order that a reader has.
PANELS: dict[str, dict[str, Any]] = {
    "Run": {"run": run, "list": list_all, "compare": compare, "study": study, "tune": tune, "report": report,
            "live": live},
    "Bring your own": {"new": new, "stage": stage},
    "Look into a stage": {"identify": identify, "linearise": linearise, "region": region},
    "Hold and hand on": {"check": check, "build": build, "target": target, "pack": pack, "cache": cache}}
for panel, commands in PANELS.items():
    for command_name, command in commands.items():
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=command_name, rich_help_panel=panel)
        else:
            app.command(command_name, rich_help_panel=panel)(command)

if __name__ == "__main__":
    app()
