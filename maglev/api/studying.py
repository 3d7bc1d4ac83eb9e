"""Studies: a scenario run many times, side by side, one Parquet dataset of all samples, and a page."""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, Unpack, cast

import numpy as np
import numpy.typing as npt

from maglev.api.options import experiments_of
from maglev.api.run import Run
from maglev.api.running import run as rerun
from maglev.api.running import say_notes
from maglev.descriptions.writer import render
from maglev.files.errors import (
    BuildError,
    MaglevError,
    ScenarioError,
    UnknownName,
    extra,
    key_path,
    option,
    require_table,
    shortened,
)
from maglev.files.scratch import scratch
from maglev.files.side_by_side import Say, Watch, processes, unwatched, warn
from maglev.files.units import number_or_text, whole_number
from maglev.many.batches import runners
from maglev.many.study_design import require_free
from maglev.many.study_file import StudyFile, load_study, read_study
from maglev.many.study_plan import plan_study
from maglev.many.tuning_plan import TuneFile
from maglev.pages.sample_commands import command_of, row_options
from maglev.runs.preparation import Experiment
from maglev.scenario.catalogue import HOST, Kind, build_written
from maglev.scenario.fmus_for_runs import compiles
from maglev.scenario.layers import packaged_files
from maglev.scenario.loading import load_plan
from maglev.scenario.options import OPTIONS, RunOptions, SampleOptions, seconds, takes_options
from maglev.scenario.settings import start_values
from maglev.user.new_stage import seen_from, toml_file, write_new
from maglev.user.source import PythonFile, Source, carried, source_of

Vary = Mapping[str, Sequence[float | int | bool | str] | npt.NDArray[Any] | str]

PUT_IN = ("plant", "controller")   # options that name what takes the place of a plan's

LIKE = "{'plant.y.mass': [6.5, 7.5]}"   # a table of parameters to vary
IN_MEMORY = 1   # of the kinds of devices of DLPack

PERCENT = re.compile(r"(?:±|\+-|\+/-)\s*(\S+?)\s*%")   # ±20%, +-20 %


class Study:
    """A study that was run: its dataset, and ways on to other tools.

    Attributes
    ----------
    path : Path
        The Parquet dataset, which pandas, Polars and DuckDB read.
    about : mapping
        Its metadata: design, limits, provenance.
    """

    def __init__(self, path: str | Path):
        extra("pyarrow", "study", "a study")
        from maglev.many.dataset import metadata_of

        self.path = Path(path)
        self.file = self.path.absolute()   # wherever this process goes
        self.about: Mapping[str, Any] = metadata_of(self.file)
        if not self.about:
            raise MaglevError(f"{path}: cannot be read, expected a dataset that `maglev study` wrote")

    @property
    def name(self) -> str:
        """Name of the study."""
        return str(self.about["name"])

    @property
    def units(self) -> dict[str, str]:
        """Units of the columns, "1" of shares, empty text of counts."""
        schema = import_module("pyarrow.parquet").read_schema(self.file)
        return {field.name: (field.metadata or {}).get(b"unit", b"").decode() for field in schema}

    def __repr__(self) -> str:
        return f"<Study {self.name}: {self.about['samples']} samples of {self.about['scenario']} in {self.path}>"

    def to_arrow(self) -> Any:
        """Table of the samples, a pyarrow.Table; MaglevError if the dataset is not as it was written."""
        from maglev.many.dataset import read_dataset

        return read_dataset(self.file)

    def to_pandas(self) -> Any:
        """Table of the samples, a pandas.DataFrame by number of the sample; `attrs["units"]` has the units."""
        extra("pandas", "data")
        frame = self.to_arrow().replace_schema_metadata(None).to_pandas().set_index("sample")
        frame.attrs["units"] = self.units
        return frame

    def to_xarray(self) -> Any:
        """Metrics of a full grid over what varies, an xarray.Dataset; ScenarioError for another design."""
        if self.about["design"]["kind"] != "grid":
            raise ScenarioError(f"{self.name}: design is {self.about['design']['kind']!r}, expected 'grid' for "
                                "dimensions; to_pandas() has the samples as they are")
        xarray, frame, units = extra("xarray", "data"), self.to_pandas(), self.units
        dimensions = [varied["name"] for varied in self.about["vary"]]
        settings = [name for name in self.about["targets"] if name in frame and name not in dimensions]
        grid = frame.drop(columns=[*settings, "ending", "failure"]).set_index(dimensions)
        dataset = xarray.Dataset.from_dataframe(grid)
        for name in dataset.variables:
            dataset[name].attrs["units"] = units.get(str(name), "")
        return dataset.assign_attrs(name=self.name, scenario=self.about["scenario"])

    def command(self, sample: int) -> str:
        """The command that runs a sample again, as a full run with files and all."""
        return command_of(self.about, self.row(sample))

    def run(self, sample: int) -> Run:
        """A sample run again as `maglev.run` does it, with everything recorded: the same bits."""
        return rerun(**row_options(self.about, self.row(sample)))

    def row(self, sample: int) -> dict[str, Any]:
        """Return a sample's row of the dataset; UnknownName if there is no sample of this number."""
        number = whole_number(sample, UnknownName, f"{self.name}: sample", 0, self.about["samples"] - 1)
        return dict(self.to_arrow().slice(number, 1).to_pylist()[0])

    def write_page(self, path: str | Path | None = None) -> Path:
        """Write the page about the study, one HTML file; next to the dataset if no path is given.

        Where `live.html` of `maglev.write_live` lies next to it, its worst samples are linked to their runs there.
        """
        from maglev.pages.study_page import write_page

        page = self.file.with_suffix(".html") if path is None else Path(path)
        write_page(page, self.to_arrow(), self.about)
        return page


@takes_options
def study(what: str | Path | StudyFile, *, vary: Vary | None = None, samples: int | None = None, seed: int = 0,
          keep: Sequence[str] = (), name: str | None = None, out: str | Path = "results", jobs: int | None = None,
          scheduler: str | None = None, resume: bool = False,
          sample_timeout: float | str | None = None, watch: Watch | None = None, say: Say | None = None,
          **options: Unpack[SampleOptions]) -> Study:
    """Run a scenario many times, with varied quantities from a file or from `vary`, and return the dataset.

    Parameters
    ----------
    what : str or Path
        A study of the package by its name, or a TOML file (docs/studies.md); with `vary` a scenario, as of `run`.
    vary : mapping of str to sequence, or to str, optional
        Values by target, `fmu.variable` or `reference.AXIS.amplitude`, or several with commas between; or
        "from:to:number". Every combination is run; or `samples` of them, a Latin hypercube, then also of ranges:
        "low:high", and "±20 %" of the nominal value.
    samples, seed : int, optional
        See `vary`.
    keep : sequence of str
        With `vary`: signals to keep as trajectories.
    name : str, optional
        With `vary`: name of the results; "SCENARIO.study" if not given.
    out : path
        Folder for NAME.parquet, and NAME.trajectories.parquet if trajectories are kept.
    jobs : int, optional
        Processes of this machine; as many as processors if not given.
    scheduler : str, optional
        Address of a Dask scheduler, "tcp://host:8786", whose workers replace this machine's processes.
    resume : bool
        Continue an interrupted study.
    sample_timeout : float or str, optional
        Longest wall time of a sample, s, or text with a unit; the file's, or none, but 600 s with third-party FMUs.
    watch, say : callable, optional
        See `run_all`.
    **options
        See `run`.

    Returns
    -------
    Study
        The same, bit for bit, whoever ran it, in whatever order, after whatever interruptions.

    Raises
    ------
    MaglevError
        If an argument cannot be used; raised before the first run.
    KeyboardInterrupt
        After Ctrl-C; finished samples are kept.

    Examples
    --------
    >>> import maglev
    >>> study = maglev.study("2dof-smooth-nonlinear", vary={"plant.v.mass": "4:5:3"})   # doctest: +SKIP
    >>> study.to_xarray()["overshoot of v"].dims                                        # doctest: +SKIP
    ('plant.v.mass',)
    """
    extra("pyarrow", "study", "a study")
    from maglev.many.study_run import run_study

    alone = {"samples": samples, "seed": seed or None, "keep": [*keep] or None, "name": name}
    if vary is None and (given := [option(key) for key, value in alone.items() if value is not None]):
        raise ScenarioError(f"{', '.join(given)}: needs {option('vary')}; {what} sets this itself")
    origin, folder = "study", Path()   # errors begin with the one, relative file names in the other
    if isinstance(what, StudyFile):
        described = what
    elif vary is not None:
        described, origin = varied(what, vary, name, keep, samples, seed), option("vary")
    else:
        described, path = load_study(what)
        origin, folder = str(path), path.parent
    limit = seconds("sample_timeout", sample_timeout)
    described = described if limit is None else described.model_copy(update={"sample_timeout": limit})
    with made_ready(described, origin, folder, options, scheduler, say or warn,
                    watch or unwatched) as (experiment, run_with):
        planned = plan_study(described, experiment, origin, Path(out), run_with)
        with (watch or unwatched)([described.name]) as watcher:
            return Study(run_study(planned, Path(out), processes(jobs), scheduler, resume,
                                   partial(watcher, described.name), say or warn))


def new_study(path: str | Path, scenario: str | Path) -> Path:
    """Write a study that runs, to begin with; nothing is overwritten. Returns the file.

    Parameters
    ----------
    path : path
        The file, NAME or NAME.toml; its results are named after it.
    scenario : str or path
        The run to repeat: one of the package by its name, or your own scenario, without variants.

    Raises
    ------
    StageError, ScenarioError
        If the file is there already, its name is not allowed, or the scenario does not exist or is not about a stage.

    Examples
    --------
    >>> import maglev
    >>> maglev.new_study("robust.toml", "2dof-setpoints").name
    'robust.toml'
    """
    file, plan = toml_file(path), load_plan(scenario)
    if plan.stage is None or "plant" not in plan.fmus:
        raise ScenarioError(f"{scenario}: fmus = {key_path(list(plan.fmus))}: expected a scenario with the plant of a "
                            "stage")
    name = seen_from(file, scenario) if str(scenario).endswith(".toml") else str(scenario)
    write_new(file, render("new/study.toml.j2", plan.stage, file=file.name, name=file.stem, scenario=name))
    return file


@contextmanager
def made_ready(study: StudyFile | TuneFile, origin: str, folder: Path, options: SampleOptions, scheduler: str | None,
               say: Say, watch: Watch) -> Iterator[tuple[Experiment, dict[str, Any]]]:
    """Yield the experiment of a study or a tuning for the block, and the JSON that repeats it with `maglev run`.

    Errors name `origin`, and relative file names begin at `folder`. Its Python files are FMUs there, because
    workers have none of the user's files. They are native if possible, and `say` is called with the reason if not. With
    a scheduler, built FMUs have binaries for all platforms.
    """
    if everywhere := scheduler is not None:
        with runners(scheduler, 1):
            pass   # an unreachable scheduler is reported before minutes of building
    settings = start_values(study.set) | start_values(options.get("set"))
    require_free(settings, study.vary, origin)
    scenario = file_or_name(folder / study.scenario) if study.scenario.endswith(".toml") else study.scenario
    put_in: dict[str, Any] = {role: carried(given) for role in PUT_IN if (given := options.get(role)) is not None}
    if (controller := getattr(study, "controller", None)) is not None:
        put_in.setdefault("controller", folder / controller)
    options = cast("RunOptions", {**options, "set": settings, **put_in})
    run = {"scenario": scenario, "set": {name: value.value for name, value in settings.items()},
           "options": {name: value if isinstance(value, bool) else str(value) for name, option in OPTIONS.items()
                       if (value := options.get(name)) not in (None, option.default) and name != "set"}}
    native = options.get("kind") == "native" or (options.get("fmus") is None and compiles(options.get("kind")))
    plan = load_plan(scenario)
    named = {name: fmu.file for name, fmu in plan.fmus.items() if name not in put_in and fmu.file is not None}
    sources = {given: source_of(given) for given in (*named.values(), *put_in.values())}
    written = {source for source in sources.values() if isinstance(source, PythonFile)}
    with scratch() as built_in:
        made: dict[Source, Path] = {source: fmu_of(source, built_in / str(number), native, everywhere, say)
                                    for number, source in enumerate(sorted(written, key=str))}
        plan = plan.model_copy(update={"fmus": {
            name: fmu.model_copy(update={"file": str(made[sources[named[name]]])})
            if name in named and sources[named[name]] in made else fmu for name, fmu in plan.fmus.items()}})
        built = cast("RunOptions", {role: made.get(sources[given], given) for role, given in put_in.items()})
        experiment, = experiments_of([plan], {**options, **built}, say, watch, everywhere)
        say_notes([experiment], say)
        yield experiment, run


def fmu_of(source: PythonFile, folder: Path, native: bool, everywhere: bool, say: Say) -> Path:
    """Build the FMU of a Python file into its own folder: several files can have classes of the same name."""
    folder.mkdir()
    if native:
        try:
            return build_written(source, folder, Kind(native=True) if everywhere else HOST)
        except BuildError as error:
            say(f"{source} runs in Python, which is slow, because it cannot be native: {error}")
    return build_written(source, folder)


def file_or_name(path: Path) -> str:
    """A scenario's file as a command names it: by its name if it is packaged, or else from the working folder on."""
    path = path.resolve()
    named = next((name for name, file in packaged_files().items() if file.resolve() == path), None)
    return named or str(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path)


def varied(scenario: object, vary: Vary, name: str | None, keep: Sequence[str], samples: int | None, seed: int
           ) -> StudyFile:
    """Return a study of a scenario without a file; see `study`."""
    if not isinstance(scenario, str | Path):
        raise ScenarioError(f"scenario: {shortened(scenario)}, expected a name or a file, so that each sample can be "
                            "run again")
    require_table(vary, "vary", ScenarioError, LIKE)
    entries = [{"set": target.split(","), **(given_values(target, values, samples is not None)
                                             if isinstance(values, str) else {"kind": "list", "values": plain(values)})}
               for target, values in vary.items()]
    table: dict[str, Any] = {"name": name or f"{Path(scenario).stem}.study", "scenario": str(scenario), "vary": entries,
                             "keep": keep}
    if samples is not None:
        table["design"] = {"kind": "latin hypercube", "samples": samples, "seed": seed}
    return read_study(table, option("vary"))


def plain(given: Any) -> Any:
    """Return values as a list, arrays of other libraries by DLPack, and anything else unchanged, to fail in a later
    check.

    ScenarioError for an array that is not in this machine's memory.
    """
    # An array with DLPack; NumPy's may have texts, which DLPack lacks.
    if hasattr(given, "__dlpack_device__") and not isinstance(given, np.ndarray):
        if given.__dlpack_device__()[0] != IN_MEMORY:
            raise ScenarioError(f"{shortened(given)}: expected an array in this machine's memory")
        given = np.from_dlpack(given)
    alone = isinstance(given, str) or not hasattr(given, "__iter__") or getattr(given, "shape", None) == ()
    return given if alone else [*given]


def given_values(target: str, text: str, sampled: bool) -> dict[str, Any]:
    """A grid "from:to:number", or values "a,b,c"; if they are sampled also a range "low:high" or "±20 %"."""
    parts = [part.strip() for part in text.split(":")]
    percent = PERCENT.fullmatch(text.strip())
    if (percent or len(parts) == 2) and not sampled:
        raise ScenarioError(f"{target}={text}: a range needs {option('samples')}; a grid is FROM:TO:NUMBER")
    if percent:
        return {"kind": "percent", "percent": f"{percent[1]} %"}
    if len(parts) == 2:
        return {"kind": "uniform", "low": number_or_text(parts[0]), "high": number_or_text(parts[1])}
    if len(parts) == 1 and ".." not in text:
        return {"kind": "list", "values": [word == "true" if word in ("true", "false") else number_or_text(word)
                                           for word in map(str.strip, text.split(","))]}
    if len(parts) != 3 or not parts[2].isdigit():
        raise ScenarioError(f"{target}={text}: expected a grid FROM:TO:NUMBER, such as -2000:-800:20, a range FROM:TO, "
                            "or values with commas between")
    return {"kind": "grid", "from": number_or_text(parts[0]), "to": number_or_text(parts[1]), "number": int(parts[2])}
