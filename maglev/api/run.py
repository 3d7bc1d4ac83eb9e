"""A finished run: columns, metrics and verdicts as data, and conversions for other tools."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from rich.text import Text

from maglev.cosim.master import Recording
from maglev.files.errors import MeasurementError, UnknownName, extra, nearest
from maglev.pages.picture import figure_of
from maglev.pages.run_text import Printable, Verdicts, show
from maglev.runs.execution import RunResult, judge_all, whole_metrics, write_columns
from maglev.runs.measures import Measure, measures_of
from maglev.runs.metrics import Metrics
from maglev.scenario.run_plan import RunPlan

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.console import Console


class Run(Printable, Mapping[str, NDArray[Any]]):
    """A completed run, a mapping of its columns by name.

    Attributes
    ----------
    plan : RunPlan
        The plan of the run: names of axes and motors, references, claims.
    time : ndarray, shape (n,)
        s, every output interval of the plan.
    columns : mapping of str to ndarray, shape (n,)
        By name, `fmu.variable`, SI; Booleans as 0 and 1. `run["plant.y.position"]` is one of them.
    units : mapping of str to str
        Of the columns, empty text where an FMU gives none.
    parameters : mapping of str to float
        Every Real parameter that the run started with, `fmu.variable`.
    """

    def __init__(self, made: RunResult, units: Mapping[str, str], recording: Recording | None = None):
        self.made = made             # measured already, or
        self.recording = recording   # with every communication point, until it is measured
        self.plan: RunPlan = made.plan
        self.time: NDArray[np.float64] = made.time
        self.columns: Mapping[str, NDArray[Any]] = made.columns
        self.units = {name: units.get(name, "") for name in self.columns}
        self.parameters: Mapping[str, float] = made.parameters

    @property
    def name(self) -> str:
        """Name of the run."""
        return self.plan.name

    @cached_property
    def metrics(self) -> Metrics:
        """Steps, tracking errors, currents, stops, trips, measured at every communication point when first asked for.

        Raises MeasurementError if a column is not finite.
        """
        if self.made.metrics is not None:
            return self.made.metrics
        assert self.recording is not None
        fresh = whole_metrics(self.plan, self.recording)
        self.recording = None
        return fresh

    @cached_property
    def result(self) -> RunResult:
        """Return the recorded columns and the metrics."""
        return replace(self.made, metrics=self.metrics)

    @property
    def measures(self) -> tuple[Measure, ...]:
        """The numbers of the metrics, a row for each: quantity, axis or motor, time of the step, value (SI), unit.

        `pandas.DataFrame(run.measures)` is a table of them.
        """
        return measures_of(self.plan, self.metrics)

    @property
    def verdicts(self) -> Verdicts:
        """Claims about this run with their verdicts, a tuple that prints as a table; comparisons are "not run"."""
        return Verdicts(judge_all([self.result])[self.name])

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return a column by its name, `fmu.variable`; UnknownName if it was not recorded."""
        if name not in self.columns:
            raise UnknownName(f"{self.name} has no column {name!r}, {nearest(name, self.columns)}")
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    # Columns of two runs are compared one by one: as a whole, numpy has no answer.
    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def __repr__(self) -> str:
        try:
            state = self.result.ending
        except MeasurementError:
            state = "cannot be measured"
        return f"<Run {self.name}: {len(self.time)} rows to {self.time[-1]:g} s, {len(self)} columns, {state}>"

    def show(self, console: "Console") -> None:
        """Print the tables of the terminal on a console of rich's; of a run that cannot be measured what it is."""
        try:
            self.metrics   # noqa: B018
        except MeasurementError as error:
            console.print(Text(f"{self!r}: {error}"))
        else:
            show(console, self.result, self.verdicts, briefly=True)

    def to_pandas(self) -> Any:
        """Table of the columns over time, a pandas.DataFrame; `attrs["units"]` has the units."""
        frame = extra("pandas", "data").DataFrame(dict(self.columns), index=self.time)
        frame.index.name = "time"
        frame.attrs["units"] = dict(self.units)
        return frame

    def to_xarray(self) -> Any:
        """Columns over the dimension `time`, an xarray.Dataset whose variables have their units."""
        variables = {name: ("time", values, {"units": self.units[name]}) for name, values in self.columns.items()}
        return extra("xarray", "data").Dataset(variables, coords={"time": ("time", self.time, {"units": "s"})},
                                               attrs={"name": self.name, "title": self.plan.title})

    def to_csv(self, path: str | Path) -> None:
        """Write the columns as `maglev run` writes them: time first, then `fmu.variable`."""
        write_columns(Path(path), "csv", self.made, self.units, self.made.recording)

    def to_parquet(self, path: str | Path) -> None:
        """Write the columns as Parquet, with their units and the provenance of the run as metadata."""
        write_columns(Path(path), "parquet", self.made, self.units, self.made.recording)

    def plot(self) -> "Figure":
        """Picture of the run, a matplotlib Figure: positions with references, errors, commands, currents."""
        return figure_of(self.result)
