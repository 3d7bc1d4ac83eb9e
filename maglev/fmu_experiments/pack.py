"""A scenario put into an FMU: what the FMU was given there, what it gave, and how close a repetition has to be."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from zipfile import ZIP_DEFLATED, BadZipFile, ZipFile

from fmi_export.experiments.files import FOLDER, VALIDATION, ExperimentFiles, carried
from maglev.baselines.outcome import CheckResult
from maglev.errors import FmuError, ScenarioError
from maglev.experiment.ports.replacement import Replacement
from maglev.experiment.preparation import Experiment, prepare
from maglev.fmu_experiments.carried import carried_experiments
from maglev.fmu_experiments.check import check_all
from maglev.fmu_experiments.recording import recorded
from maglev.processes.side_by_side import Watcher
from maglev.schema.loading import load_plan
from maglev.schema.run_plan import RunPlan
from maglev_files.whole_file import whole_file

LARGEST = 5_000_000   # bytes of an experiment: it goes with every copy of the FMU


def pack_reference(fmu: str | Path, scenario: str | Path, *, name: str | None = None, out: str | Path | None = None,
                   fmus: str | Path = "fmus", watch: Watcher = lambda name, done, steps: None) -> CheckResult:
    """Fly a scenario with an FMU, and put into it what it was given and gave there, as an experiment for it alone.

    The experiment is a validation by the layered standard FMI-LS-REF. What the scenario's baseline would hold of the
    FMU, the signals and tolerances of its table `check`, is what is compared; without any it is every output. The FMU
    is then flown alone from what was put in: where that does not give the same, nothing is written.

    Parameters
    ----------
    fmu : path
        The FMU, of FMI 2.0 or 3.0, for co-simulation.
    scenario : str or Path
        Name of a run, or a TOML file with one.
    name : str, optional
        Whose place the FMU takes in the scenario, such as "controller"; not needed where the scenario names its file.
    out : path, optional
        Where to write; the FMU itself if not given.
    fmus : path
        Folder with the FMUs of this project.
    watch : callable, optional
        Told the name of the run, and the steps done and in all.

    Returns
    -------
    CheckResult
        Of the repetition.

    Raises
    ------
    MaglevError
        If the run cannot be flown, takes too much room, or is not repeated by the FMU alone.
    """
    path, plan = Path(fmu), load_plan(scenario)
    if plan.needs:
        raise ScenarioError(f"{plan.path}: starts from the run {', '.join(sorted(plan.needs))}, expected a run that "
                            "needs no other")
    place = name or named_place(plan, path)
    if place not in plan.fmus:
        raise ScenarioError(f"{place}: is not in the scenario {plan.name}, expected one of {', '.join(plan.fmus)}")
    experiment = prepare(plan, Path(fmus), {} if name is None else {place: Replacement(path)}, {})
    recording = experiment.run(lambda done, steps: watch(plan.name, min(done, steps - 1), steps))
    found = as_in_baseline(recorded(experiment, recording, place, plan.name, VALIDATION,
                                    f"As {place} in the scenario {plan.name}: {plan.title}", rows_apart(experiment)),
                           plan, place)
    files = found.files()
    size = sum(map(len, files.values()))
    if size > LARGEST:
        raise ScenarioError(f"{plan.path}: stop_time = {plan.stop_time} s: the experiment takes {1e-6 * size:.1f} MB, "
                            f"expected at most {1e-6 * LARGEST:g} MB: a shorter scenario")
    with whole_file(Path(out) if out is not None else path) as unfinished:
        with_experiment(path, unfinished, plan.name, files)
        own = [each for each in carried_experiments(unfinished) if each.name == plan.name]
        result, = check_all({plan.name: (unfinished, own[0])}, 1, watch)
        if result.status != "passed":
            raise FmuError(f"{path}: flown alone with what it got in {plan.name} it {result.message}; expected what it "
                           "gave there, and nothing is written")
    return result


def named_place(plan: RunPlan, path: Path) -> str:
    """Name, in a scenario, of the FMU of a file that it names."""
    for place, fmu in plan.fmus.items():
        if fmu.file is not None and Path(fmu.file).resolve() == path.resolve():
            return place
    raise ScenarioError(f"{plan.path}: names no FMU {path}, expected --as with what it takes the place of, one of "
                        f"{', '.join(plan.fmus)}")


def rows_apart(experiment: Experiment) -> int:
    """Communication steps between two rows of the results."""
    check = experiment.plan.check
    return max(1, round(check.interval / experiment.step)) if check.signals else experiment.output_every()


def as_in_baseline(found: ExperimentFiles, plan: RunPlan, place: str) -> ExperimentFiles:
    """The experiment with the results and tolerances that a baseline of the scenario has of the FMU, if it has any."""
    wanted = {signal.removeprefix(f"{place}."): tolerance for signal, tolerance in plan.check.signals.items()
              if signal.removeprefix(f"{place}.") in found.results and signal.startswith(f"{place}.")}
    if not wanted:
        return found
    return replace(found, results={key: found.results[key] for key in ("time", *wanted)},
                   tolerances={key: (value.absolute, value.relative) for key, value in wanted.items()})


def with_experiment(path: Path, destination: Path, name: str, files: Mapping[str, bytes]) -> None:
    """Write an FMU with the files of an experiment in it, beside those that it has already."""
    try:
        with ZipFile(path) as archive, ZipFile(destination, "w", ZIP_DEFLATED) as written:
            before = {entry: archive.read(entry) for entry in archive.namelist() if entry.startswith(FOLDER)}
            new = carried({name: (VALIDATION, files)}, before)
            for entry in archive.infolist():
                if entry.filename not in new:
                    written.writestr(entry, archive.read(entry))
            for file, data in new.items():
                written.writestr(file, data)
    except BadZipFile as error:
        raise FmuError(f"{path}: cannot be read as an FMU: {error}") from error
