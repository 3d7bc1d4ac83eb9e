"""A batch: a scenario run with many values, side by side, with its metrics as arrays and no files."""

import tempfile
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt

from maglev.api.run import Run
from maglev.api.running import run as rerun
from maglev.api.studying import LIKE, made_ready, plain
from maglev.files.errors import (
    Interrupted,
    ScenarioError,
    UnknownName,
    ended_by,
    extra,
    nearest,
    require_table,
    signal_of,
)
from maglev.files.side_by_side import Say, Watch, processes, unwatched, warn
from maglev.files.units import whole_number
from maglev.many.batches import runners
from maglev.many.samples import BatchResult
from maglev.many.study_file import read_study
from maglev.many.study_plan import plan_study
from maglev.pages.sample_commands import row_options
from maglev.scenario.options import SampleOptions, takes_options

UNDONE = "was not run: the batch was interrupted"


class BatchInterrupted(Interrupted):
    """Ctrl-C or SIGTERM ended a batch; `batch` has the samples that were done until then."""

    def __init__(self, message: str, batch: "Batch", number: int):
        super().__init__(message, number)
        self.batch = batch


class Batch:
    """Samples that were run.

    Attributes
    ----------
    settings : mapping of str to ndarray, shape (samples,)
        Values that each sample sets.
    columns : mapping of str to ndarray, shape (samples,)
        Metrics, SI, named as the columns of a study; NaN where a sample did not complete.
    units : mapping of str to str
        Of the metrics; "1" of a share, empty text of a count.
    failures : tuple of str or None
        The reason for each sample that did not complete.
    signals : mapping of str to ndarray, shape (samples, points)
        Kept trajectories, at `time` (s).
    """

    def __init__(self, about: Mapping[str, Any], settings: Mapping[str, npt.NDArray[Any]],
                 columns: Mapping[str, npt.NDArray[np.float64]], units: Mapping[str, str],
                 failures: Sequence[str | None], signals: Mapping[str, npt.NDArray[np.float64]],
                 time: npt.NDArray[np.float64]):
        self.about = about
        self.settings, self.columns, self.units = settings, columns, units
        self.failures, self.signals, self.time = tuple(failures), signals, time

    def __len__(self) -> int:
        return len(self.failures)

    def __repr__(self) -> str:
        failed = sum(why is not None for why in self.failures)
        return (f"<Batch of {self.about['scenario']}: {len(self)} samples, {failed} not completed, "
                f"{len(self.columns)} metrics>")

    def __getitem__(self, name: str) -> npt.NDArray[np.float64]:
        """Return a metric by its name; UnknownName with the nearest if there is none."""
        if name not in self.columns:
            raise UnknownName(f"there is no metric {name!r}, {nearest(name, self.columns)}")
        return self.columns[name]

    @property
    def metrics(self) -> Any:
        """Return metrics and kept trajectories as an xarray.Dataset by sample (extra `data`)."""
        data: dict[str, Any] = {name: ("sample", values, {"units": self.units[name]})
                                for name, values in self.columns.items()}
        data |= {name: (("sample", "time"), values) for name, values in self.signals.items()}
        coordinates = {name: ("sample", values) for name, values in self.settings.items()}
        times = {"time": self.time} if self.signals else {}
        return extra("xarray", "data").Dataset(data, {"sample": np.arange(len(self)), **coordinates, **times},
                                               {"scenario": self.about["scenario"]})

    def run(self, sample: int) -> Run:
        """Run a sample with `maglev.run`, with everything recorded: the same bits."""
        number = whole_number(sample, UnknownName, "sample", 0, len(self) - 1)
        return rerun(**row_options(self.about, {name: values[number].item() for name, values in self.settings.items()}))


@takes_options
def batch(scenario: str | Path, values: Mapping[str, Sequence[Any] | npt.NDArray[Any]], *,
          metrics: Sequence[str] | None = None, keep: Sequence[str] = (), keep_interval: float | None = None,
          jobs: int | None = None, watch: Watch | None = None, say: Say | None = None,
          **options: Unpack[SampleOptions]) -> Batch:
    """Run a scenario once for each row of values, side by side.

    In a long batch native FMUs of this installation run in one loop in C, by threads of this process. The loop is
    compiled first, where a compiler is installed. Other FMUs, and short batches, run in processes of their own. The
    bits are the same.

    Parameters
    ----------
    scenario : str or Path
        As of `run`.
    values : mapping of str to sequence, shape (samples,)
        By target: a parameter or input `fmu.variable`, a reference `reference.AXIS.amplitude`, or several with commas
        between. Sample k takes the k-th value of each. Arrays of other libraries come by DLPack.
    metrics : sequence of str, optional
        Such as "overshoot", "settling time to 10 µm of y"; all without it.
    keep : sequence of str
        Signals to keep as trajectories.
    keep_interval : float, optional
        Between their points, s; the scenario's without it.
    jobs : int, optional
        Threads or processes; as many as processors if not given.
    watch, say : callable, optional
        As of `run_all`.
    **options
        As of `run`.

    Returns
    -------
    Batch
        A sample that does not complete is a row with its reason; the others continue.

    Raises
    ------
    MaglevError
        If an argument cannot be used; raised before the first sample.
    BatchInterrupted
        After Ctrl-C; its `batch` has the samples that were done.

    Examples
    --------
    >>> import maglev
    >>> found = maglev.batch("2dof-smooth-nonlinear", {"plant.v.mass": [4.0, 4.35, 5.0]})   # doctest: +SKIP
    >>> found["overshoot of v"].shape                                                       # doctest: +SKIP
    (3,)
    """
    require_table(values, "values", ScenarioError, LIKE)
    entries = [{"set": target.split(","), "kind": "list", "values": plain(given)} for target, given in values.items()]
    study = read_study({"name": "batch", "scenario": str(scenario) if isinstance(scenario, Path) else scenario,
                        "vary": entries, "design": {"kind": "rows"}, "keep": keep, "metrics": metrics,
                        "keep_interval": keep_interval}, "batch")
    with made_ready(study, "batch", Path(), options, None, say or warn, watch or unwatched) as (experiment, run_with):
        planned = plan_study(study, experiment, "batch", Path(tempfile.gettempdir()), run_with)
        count, job = len(planned.values), planned.job
        columns = np.full((count, len(job.columns)), np.nan)
        signals = np.full((count, len(planned.times), len(job.kept)), np.nan)
        failures: list[str | None] = [UNDONE] * count

        def made() -> Batch:
            settings = {target.name: planned.values[:, i].astype(bool) if target.boolean else planned.values[:, i]
                        for i, target in enumerate(job.targets)}
            return Batch(planned.about, settings,
                         {column.name: columns[:, i] for i, column in enumerate(job.columns)},
                         {column.name: column.unit for column in job.columns}, failures,
                         {name: signals[:, :, i] for i, name in enumerate(job.kept)}, planned.times)

        with (watch or unwatched)([study.scenario]) as watcher, runners(None, processes(jobs)) as run_batches:
            tell = partial(watcher, study.scenario)
            done = 0

            def store(result: BatchResult) -> None:
                nonlocal done
                rows = slice(result.first, result.first + len(result.failures))
                columns[rows] = result.values
                if result.trajectories is not None:
                    signals[rows] = result.trajectories
                failures[rows] = result.failures
                done += len(result.failures)
                tell(done, count)

            try:
                run_batches(job, planned.batches, planned.values, store)
            except KeyboardInterrupt as error:
                raise BatchInterrupted(f"{ended_by(error)}: {done} of {count} samples are done; the attribute `batch` "
                                       "of this exception has them", made(), signal_of(error)) from None
    return made()
