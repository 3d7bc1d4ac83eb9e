"""One scenario flown again and again in one process: loaded and wired once, reset between, arrays used again."""

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from maglev.arrays import Array
from maglev.cosim.master import Columns, Master
from maglev.experiment.preparation import Experiment, is_foreign
from maglev.schema.settings import REFERENCE, start_values, with_references

Changes = Mapping[str, float | bool]   # start values `fmu.variable`, and references `reference.AXIS.amplitude`


class Flight:
    """An experiment to be flown many times with other start values; a context manager that frees its FMUs.

    Of what is recorded the columns `wanted` are kept, all without it.

    Each flight gives, bit for bit, what the experiment gives that is prepared with the same values: FMUs of this
    project are as new after fmi2Reset. Those of others, and all after a refusal, are loaded anew.
    """

    def __init__(self, experiment: Experiment, wanted: Collection[str] | None = None):
        self.experiment = experiment
        self.wanted = wanted
        self.resettable = not any(map(is_foreign, experiment.files.values()))
        self.descriptions = experiment.check()
        self.drives = experiment.drives(self.descriptions)
        self.master: Master | None = None
        self.columns: Columns | None = None   # of the flights of one master, all in the same memory
        self.redriven = False   # the references are not those of the experiment

    def __enter__(self) -> "Flight":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the FMUs; the next flight loads them again."""
        if self.master is not None:
            self.master.__exit__()
        self.master = None

    def load(self, build: bool = False) -> Master:
        """FMUs and calls, loaded and wired if they are not yet.

        The FMUs' blocks are in the loop if that was compiled before, or is compiled now, where `build` asks for it.
        """
        if self.master is None:
            experiment = self.experiment
            self.master = Master(experiment.setups(), experiment.connections, experiment.step, experiment.order,
                                 loop=experiment.loop)
            self.master.wire(self.experiment.plan.stop_time, self.drives)
            assert self.master.wiring is not None
            self.master.with_blocks(build)
            self.columns = Columns(self.master.wiring.tracks, self.master.steps + 1, np.float64, self.wanted)
            self.redriven = False
        return self.master

    def fly(self, changes: Changes) -> tuple[Array, Mapping[str, Array]]:
        """Fly with other values.

        Time (s) and columns by name as of a `Recording`, shape (n,) each, which the next flight overwrites. MaglevError
        if an FMU refuses a value or a step; the message says when.
        """
        start: dict[str, dict[str, float | bool]] = {}
        following = self.experiment.following
        for full, value in {**(following.settings(changes) if following else {}), **changes}.items():
            name, _, variable = full.partition(".")
            start.setdefault(name, {})[variable] = value
        try:
            master = self.load()
            self.drive(master, changes)
            recording = master.fly(start, columns=self.columns)
        except BaseException:
            self.close()
            raise
        if not self.resettable:
            self.close()
        return recording.time, recording.columns

    def drive(self, master: Master, changes: Changes) -> None:
        """Put the references of a flight into the rows that the FMUs read."""
        varied = any(name.startswith(f"{REFERENCE}.") or name in self.drives for name in changes)
        if varied or self.redriven:
            # Those that a study varies go where it asks: a stop that is touched is what it finds.
            master.drive(self.with_changes(changes).references(self.descriptions) if varied else self.drives)
        self.redriven = varied

    def with_changes(self, changes: Changes) -> Experiment:
        """The experiment with other references."""
        plan, about_fmus, _ = with_references(self.experiment.plan, start_values(changes))
        fmus = dict(plan.fmus)
        for full, value in about_fmus.items():
            name, _, variable = full.partition(".")
            fmus[name] = fmus[name].model_copy(update={"start": {**fmus[name].start, variable: value}})
        return replace(self.experiment, plan=plan.model_copy(update={"fmus": fmus}))
