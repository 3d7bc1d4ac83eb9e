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
from maglev.cli.streams import CommandLine
from maglev.cli.study import compare_controllers, study, tune
from maglev.cli.terminal import one_line_errors, progress_of, require_environment, run_and_print, say
from maglev.files.errors import ScenarioError
from maglev.scenario.options import OPTIONS, KindName

app = CommandLine(context_settings={"help_option_names": ["-h", "--help"]}, help="""
Simulate magnetically levitated stages with their controllers, as FMUs.

Run a scenario and open its page:

    maglev run 3dof-setpoints --open

Write a controller in Python, change it, and run it:

    maglev new controller lqi.py
    maglev run 3dof-setpoints --controller lqi.py

List the scenarios and FMUs, or show the help of a command:

    maglev list
    maglev run --help

The exit code is 0 on success. It is 1 if a check deviates, or with `--fail-on-claims` if a run fails or misses a
claim. It is 2 after an error, or if a run did not reach its stop time; 130 after Ctrl-C, 143 after SIGTERM, 141 if the
output was cut off.
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


def build(names: Annotated[list[str] | None, typer.Argument(
              metavar="NAME", help="FMUs (all by default), or Python files with controllers.",
              show_default=False)] = None,
          stage: StageFile = None, fmus: Built = Path("fmus"),
          kind: Annotated[KindName, typer.Option(
              "--kind", metavar="KIND", help="`python` or `native`.")] = "python",
          fmi: Annotated[int, typer.Option("--fmi", metavar="N", min=2, max=3,
                                           help="FMI version of native FMUs, 2 or 3.")] = 2,
          clocked: Annotated[bool, typer.Option(
              "--clocked", help="With --fmi 3: sample on a clock of the importer.")] = False,
          target: Annotated[str, typer.Option(
              metavar="TARGET", help="Of native FMUs: `all`, `host` or `wasm`.")] = "all",
          source: Annotated[Path | None, typer.Option(
              "--from", metavar="ARCHIVE", help="Copy native FMUs of a release; no compiler needed.",
              show_default=False)] = None,
          ssp: Annotated[str | None, typer.Option(
              "--ssp", metavar="SCENARIO", help="Write a whole run as one file NAME.ssp.", show_default=False,
              autocompletion=run_names)] = None,
          debug: Debug = False) -> None:
    """Build FMUs for other tools.

    The same sources give the same bytes. A run builds the FMUs it needs, so it needs no `maglev build`.

    `python` FMUs need Python on the target machine, `native` ones do not. Native FMUs have binaries for Linux, Windows
    and macOS (`--target all`), for this machine (`host`), or for browsers (`wasm`); they need the extra `native`. The
    subfolders `native`, `fmi3`, `clocked` and `wasm` keep the kinds apart.

    Build two FMUs, once in Python and once native:

        maglev build Plant3DOF Regulator3DOF
        maglev build --kind native --target host Plant3DOF Regulator3DOF

    Build the FMU of your own controller, or those of your own stage:

        maglev new controller lqi.py
        maglev build lqi.py
        maglev new stage mine.toml
        maglev build --stage mine.toml

    Write a scenario with its FMUs as one file for tools that read SSP:

        maglev build --ssp 3dof-thrust-loss-loose
    """
    with one_line_errors(debug):
        with progress_of(["FMUs"]) as watch:
            paths = maglev.build(names or (), stage=stage, fmus=fmus, kind=kind, fmi=fmi, target=target,
                                 source=source, clocked=clocked, ssp=ssp, say=say, watch=partial(watch, "FMUs"))
        for path in paths:
            typer.echo(f"{path}  {path.stat().st_size / 1000:.0f} kB")


@with_run_options(OPTIONS)
def run(names: Names = None, everything: All = False, out: Out = Path("results"),
        open_page: Annotated[bool, typer.Option("--open", help="Write the page of the run, and open it.")] = False,
        plot: Annotated[bool, typer.Option("--plot", help="Also write pictures (needs matplotlib).")] = False,
        fail_on_claims: Annotated[bool, typer.Option(
            "--fail-on-claims", help="Exit with 1 if a run fails or misses a claim.")] = False,
        claims: Claims = None, form: Form = "csv", every: Every = None,
        json: Annotated[bool, typer.Option("--json", help="Print metrics, verdicts and provenance as JSON.",
                                           rich_help_panel=MORE)] = False,
        jobs: Jobs = None, debug: Debug = False, **options: Any) -> None:
    """Run scenarios and judge their claims.

    Run a scenario with a heavier platform, and plot it:

        maglev run 3dof-setpoints --set plant.y.mass=7.2kg --plot

    Run it with your own controller, and open its page:

        maglev new controller lqi.py
        maglev run 3dof-setpoints --controller lqi.py --open

    Run all variants of a scenario, or one:

        maglev run 2dof-step-4
        maglev run 2dof-step-4-linear

    Run your own scenario in a CI job, which fails with its claims:

        maglev new scenario mine.toml
        maglev run mine.toml --fail-on-claims

    Each run writes `NAME.csv` or `.parquet` (signals), `NAME.json` (metrics, provenance) and `NAME.txt`. Claims are in
    `claims.md`, curves of a procedure of several runs in `PROCEDURE.curves.csv`. A run that ends early leaves
    `NAME.partial.csv`.
    """
    with one_line_errors(debug):
        if everything == bool(names):
            raise ScenarioError("expected the name of a scenario, or --all" if not names else
                                f"--all and {', '.join(names)}: expected one of them")
        run_and_print(names, json=json, debug=debug, fail_on_claims=fail_on_claims, open_page=open_page, out=out,
                      plot=plot, page=open_page and "run", claims=claims, format=form, every=every,
                      jobs=jobs, **options)


@with_run_options(OPTIONS)
def report(names: Names = None, out: Out = Path("results"),
           open_page: Annotated[bool, typer.Option("--open", help="Open the page in the browser.")] = False,
           what_if: Annotated[bool, typer.Option(help="Repeat without friction if it explains a miss.",
                                                 show_default=False)] = True,
           claims: Claims = None, jobs: Jobs = None, debug: Debug = False, **options: Any) -> None:
    """Run scenarios (all by default) and write one page about them.

    `report.html` has the figures of the thesis, which zoom, the claims with their verdicts, and a moving picture of the
    stage. It needs no network.

    Report every scenario, or two:

        maglev report
        maglev report 3dof-setpoints 3dof-setpoints-improved --open

    Write the report of your own controller:

        maglev new controller lqi.py
        maglev report 3dof-setpoints --controller lqi.py
    """
    with one_line_errors(debug):
        run_and_print(names, debug=debug, open_page=open_page, out=out, page=True, what_if=what_if, claims=claims,
                      jobs=jobs, **options)


@with_run_options(["fmus"])
def live(files: Annotated[list[str] | None, typer.Argument(
             metavar="FILE", help="Your own stages and scenarios; by default all packaged ones.",
             show_default=False)] = None,
         out: Out = Path("results"), debug: Debug = False, **options: Any) -> None:
    """Write the page `live.html`, which runs the stages in a browser.

    Drag and kick the platform, change parameters, swap controllers. The page needs no network and no installation. Its
    FMUs are WebAssembly; a missing one is built, which needs the extra `native`.

    Write the page of the packaged stages:

        maglev live --out page

    Write `live-mine.html` for your own stage:

        maglev new stage mine.toml
        maglev live mine.toml mine-setpoints.toml
    """
    with one_line_errors(debug):
        path = maglev.write_live(out, files=files or (), say=say, watch=progress_of, **options)
        typer.echo(f"{path}  {path.stat().st_size / 1000:.0f} kB")


# In the order in which a reader needs them.
PANELS: dict[str, dict[str, Any]] = {
    "Run": {"run": run, "list": list_all, "compare": compare_controllers, "study": study, "tune": tune,
            "report": report, "live": live},
    "Bring your own": {"new": new, "stage": stage},
    "Analyse": {"identify": identify, "linearise": linearise, "region": region},
    "Verify and export": {"check": check, "build": build, "target": target, "pack": pack, "cache": cache}}
for panel, commands in PANELS.items():
    for command_name, command in commands.items():
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=command_name, rich_help_panel=panel)
        else:
            app.command(command_name, rich_help_panel=panel)(command)

if __name__ == "__main__":
    app()
