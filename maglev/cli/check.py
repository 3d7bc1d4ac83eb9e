"""The command `maglev check`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import maglev
from maglev.cli.options import Debug, Jobs, NamesOrFmus, Out, with_run_options
from maglev.cli.terminal import one_line_errors, print_outcomes, progress_of, say
from maglev.files.errors import ScenarioError
from maglev.scenario.options import OPTIONS, CheckOptions, completed_options

if TYPE_CHECKING:
    from maglev.runs.check_outcome import CheckResult


@with_run_options(CheckOptions.__annotations__)
def check(names: NamesOrFmus = None,
          update: Annotated[bool, typer.Option("--update", help="Write new baselines, and print the changes.")] = False,
          baselines: Annotated[Path | None, typer.Option(metavar="FOLDER", help="Folder of baselines; by default the "
                                                         "package's.", show_default=False)] = None,
          junit: Annotated[Path | None, typer.Option(metavar="FILE", help="Also write the outcome as JUnit XML.",
                                                     show_default=False)] = None,
          partial: Annotated[bool, typer.Option(
              "--partial", help="Pass an FMU that lacks columns or the end.")] = False,
          plot: Annotated[bool, typer.Option("--plot", help="Draw each deviating run (needs matplotlib).")] = False,
          out: Out = Path("results"), jobs: Jobs = None, debug: Debug = False, **options: Any) -> None:
    """Compare runs of scenarios (all by default) with their baselines.

    FMUs of this project must match the digest of all signals in `digests.txt` bit for bit. Third-party FMUs must match
    the samples in `NAME_ref.csv` within the scenario's tolerances.

    An FMU file as the argument is checked against its own reference experiments: those inside it (FMI-LS-REF), or
    `NAME_ref.csv`, `NAME_in.csv` and `NAME_ref.opt` next to `NAME.fmu`.

    Exit codes: 0 all runs pass; 1 a run deviates; 2 a run could not be compared.

    Check every scenario, and write the outcome for CI:

        maglev check --junit check.xml

    Check one scenario, and draw it if it deviates:

        maglev check 3dof-smooth-nonlinear --plot
    """
    with one_line_errors(debug):
        if update and junit is not None:
            raise ScenarioError(f"--junit {junit}: cannot be combined with --update, which checks nothing")
        if junit is not None and not junit.name:
            raise ScenarioError(f"--junit: expected the name of a file, got '' or {junit}")
        from maglev.runs.check_outcome import exit_code, write_junit

        fmus = [Path(name) for name in names or () if name.lower().endswith(".fmu")]
        runs = [name for name in names or () if not name.lower().endswith(".fmu")]
        if partial and not fmus:
            raise ScenarioError("--partial: needs an FMU; a scenario is always compared as a whole")
        if fmus and update:
            raise ScenarioError(f"{fmus[0]}: --update takes scenarios; `maglev pack ref` puts one into an FMU")
        if update:
            updated = maglev.update(names or None, baselines=baselines, jobs=jobs, watch=progress_of, say=say,
                                    **options)
            print_outcomes(updated)
            raise typer.Exit(exit_code(updated))
        timeout = float(completed_options({"timeout": options["timeout"]})["timeout"])
        checked: list[CheckResult] = []
        if runs or not fmus:
            checked += maglev.check(runs or None, baselines=baselines, pictures=out if plot else None, jobs=jobs,
                                    watch=progress_of, say=say, **options)
        else:
            # An FMU alone is run as its experiments say.
            for name, value in {**options, "timeout": OPTIONS["timeout"].default, "baselines": baselines}.items():
                if value != (OPTIONS[name].default if name in OPTIONS else None):
                    flag = OPTIONS[name].flag if name in OPTIONS else f"--{name}"
                    raise ScenarioError(f"{flag}: needs a scenario; {fmus[0]} is run as its experiments say")
        if fmus:
            of_fmus = maglev.check_fmus(fmus, jobs=jobs, timeout=timeout, partial=partial, watch=progress_of)
            for result in of_fmus:
                for note in result.notes:
                    say(f"{result.name}: {note}")
            checked += of_fmus
        print_outcomes(checked)
        if junit is not None:   # if it cannot be written, the results have been printed
            write_junit(junit, checked)
        raise typer.Exit(exit_code(checked))
