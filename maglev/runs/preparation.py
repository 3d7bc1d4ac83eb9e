"""A run made ready to run: FMU files, start values and reference signals, then measured and judged."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from fmpy.model_description import ModelDescription, ScalarVariable
from numpy.typing import NDArray

from maglev.cosim import Order
from maglev.cosim.fmi_versions import FMI3
from maglev.cosim.isolated_run import TIMEOUT, Complete, IsolatedRun, run_apart
from maglev.cosim.master import FmuSetup, Master, Recording, RunFailed
from maglev.cosim.open import describe
from maglev.cosim.port_map import PortMap, apply
from maglev.cosim.step_loop import LIBRARY, own_loop
from maglev.cosim.wiring import Drives
from maglev.descriptions.own_fmus import own_fmu, stale
from maglev.descriptions.registry import known_stages
from maglev.files.arrays import Array
from maglev.files.cache import Kept, digest_at
from maglev.files.errors import ControllerError, FmuError, MaglevError, ScenarioError, few, option
from maglev.files.fmi_units import typeset_unit
from maglev.files.side_by_side import Progress
from maglev.files.time_grid import whole_steps
from maglev.files.units import refused_as
from maglev.runs.plan_check import check_names, require_reachable
from maglev.runs.provenance import Provenance, UsedFmu, departures_of
from maglev.runs.replacement import Replacement, fit, known_ports, require_essential
from maglev.runs.starts import (
    Following,
    Starts,
    in_declared_units,
    known_participant,
    known_start,
    of_declared_types,
    without_fed,
)
from maglev.scenario.options import OPTIONS, RunOptions, completed_options
from maglev.scenario.run_plan import RunPlan, StartValue
from maglev.scenario.settings import with_references
from maglev.scenario.signals import Csv, Signal
from maglev.user.adoption import know_stage
from maglev.user.source import FmuFile, PythonClass, Source, file_source


@dataclass(frozen=True)
class Experiment:
    """A run with its FMUs."""

    plan: RunPlan
    # of each FMU of the plan, in the order of stepping: copies, made when the experiment was
    sources: dict[str, Source]
    step: float   # communication step, s
    # why start values of the plan, `fmu.variable`, are not given to the FMU that was put in
    left_out: dict[str, str] = field(default_factory=dict)
    order: Order = OPTIONS["order"].default   # "sequential" or "jacobi", see `wire`
    # what the FMUs that were put in call their ports, by name in the run
    ports: dict[str, PortMap] = field(default_factory=dict)
    notes: tuple[str, ...] = ()   # sentences about inputs or outputs that these FMUs lack or leave open
    changes: tuple[str, ...] = ()   # values that differ from the plan's
    put_in: tuple[str, ...] = ()   # names of the FMUs that take the place of the plan's
    timeout: float = TIMEOUT   # longest time that a call of an FMU which is not of this project may take, s
    # why it is not the package's experiment although no change was asked for: its FMUs, its scenario
    departures: tuple[str, ...] = ()
    following: Following | None = None   # how the controller's model follows the masses of the plant, if it does
    # signals of the plan that are not compared with its baseline, for the FMUs that were put in lack them
    not_compared: tuple[str, ...] = ()
    loop: Kept | None = None   # library that makes the steps, where all that runs are FMUs
    # sentences about FMUs of this project that are not what it builds now; they are among the notes
    stale: tuple[str, ...] = ()
    parameter_sets: dict[str, str] = field(default_factory=dict)   # SHA-256 of files with start values, by path

    def provenance(self, descriptions: Mapping[str, ModelDescription] | None = None) -> Provenance:
        """Return the provenance of its results; see `variables` for the parameter."""
        descriptions = descriptions or self.check()
        fmus = tuple(UsedFmu.of(
            name, source, descriptions[name], put_in=name in self.put_in,
            start={variable: value.given for variable, value in self.plan.fmus[name].start.items()},
            left_out={full.partition(".")[2]: reason for full, reason in self.left_out.items()
                      if full.startswith(f"{name}.")}) for name, source in self.sources.items())
        return Provenance(fmus=fmus, changes=self.changes, scenario=self.plan.sha256, departures=self.departures,
                          libraries={} if self.loop is None else {LIBRARY: self.loop.sha256},
                          parameter_sets=self.parameter_sets)

    def check(self) -> dict[str, ModelDescription]:
        """Return the model descriptions; FmuError or ScenarioError if they lack a name of the plan."""
        know_stage_of(self.plan)
        descriptions = {name: describe(name, source, self.timeout) for name, source in self.sources.items()}
        for name, ports in self.ports.items():
            apply(ports, descriptions[name])
        require_essential(self.plan, {name: self.sources[name] for name in self.ports}, descriptions)
        check_names(self.plan, {name: {v.name: v for v in description.modelVariables}
                                    for name, description in descriptions.items()}, self.sources)
        return descriptions

    def require_current(self) -> None:
        """Refuse FMUs of this project that are not what it builds now, where what is found stands for these."""
        if self.stale:
            raise FmuError(f"{'; '.join(self.stale)}; {option('plant')} and {option('controller')} take any file")

    def exact(self) -> bool:
        """Return True if it has the same bits on every machine: FMUs of this project, and files in its exact
        arithmetic.

        A run with replaced FMUs is compared with another controller or plant, and so within tolerances.
        """
        know_stage_of(self.plan)
        return (not self.put_in and self.order == "sequential" and self.step == self.plan.step
                and all(source.keeps_bits() for source in self.sources.values()))

    def fits(self) -> bool:
        """Return True if `check` finds no error."""
        try:
            self.check()
        except (FmuError, ScenarioError):
            return False
        return True

    @property
    def times(self) -> Array:
        """Communication points, s, shape (n,)."""
        return self.step * np.arange(whole_steps(self.plan.stop_time, self.step) + 1, dtype=np.float64)

    def drives(self, descriptions: Mapping[str, ModelDescription]) -> dict[str, NDArray[np.float64]]:
        """Return the values of `references`; ScenarioError if one is beyond the stops of the plant that follows it."""
        drives = self.references(descriptions)
        require_reachable(self.plan, self.times, drives, self.parameters(descriptions).get)
        return drives

    def references(self, descriptions: Mapping[str, ModelDescription],
                   known: tuple[Sequence[Signal], Mapping[str, Array]] = ((), {})) -> dict[str, NDArray[np.float64]]:
        """Values of the reference signals and their rates at every communication point, shape (n,).

        The reference of an axis that has no signal stays at its start value; it is driven to be recorded. Values of
        signals that are among `known`, and not only equal, are taken from there.
        """
        times, drives = self.times, {}
        signals, values = known
        for signal in self.plan.signals:
            unchanged = any(signal is one for one in signals)
            drives[signal.to] = values[signal.to] if unchanged else signal.values_at(times)
            if signal.rate_to is not None:
                drives[signal.rate_to] = values[signal.rate_to] if unchanged else signal.rates_at(times)
        given = {*(source for source, _ in self.plan.wires.values()), *drives, *self.outputs(descriptions)}
        for axis in self.plan.axes.values():
            if axis.reference not in given:
                drives[axis.reference] = np.full(len(times), self.start_value(axis.reference, descriptions))
        return drives

    def start_value(self, name: str, descriptions: Mapping[str, ModelDescription]) -> float:
        """Start value of an input or parameter, `fmu.variable`: the plan's, or the FMU's; of Booleans 0 and 1."""
        fmu, _, variable = name.partition(".")
        if variable in self.plan.fmus[fmu].start:
            return float(self.plan.fmus[fmu].start[variable].value)
        text = next(v.start for v in descriptions[fmu].modelVariables if v.name == variable)
        return float(text == "true") if text in ("true", "false") else float(text)

    def variables(self, descriptions: Mapping[str, ModelDescription] | None = None) -> dict[str, ScalarVariable]:
        """Variables of all FMUs by their names `fmu.variable`; of those that `check` gives, if they are not given."""
        return {f"{name}.{variable.name}": variable for name, description in (descriptions or self.check()).items()
                for variable in description.modelVariables}

    def parameters(self, descriptions: Mapping[str, ModelDescription] | None = None) -> dict[str, float]:
        """Start value of every Real parameter, `fmu.variable`: the plan's, or the FMU's."""
        given = {f"{name}.{variable}": start.value for name, fmu in self.plan.fmus.items()
                 for variable, start in fmu.start.items()}
        return {full: float(given.get(full, variable.start)) for full, variable in self.variables(descriptions).items()
                if variable.causality == "parameter" and variable.type == "Real"}

    def outputs(self, descriptions: Mapping[str, ModelDescription] | None = None) -> dict[str, str]:
        """Unit of every Real output, by its name `fmu.variable`; empty text where the FMU gives none."""
        return {full: variable.unit or "" for full, variable in self.variables(descriptions).items()
                if variable.causality == "output" and variable.type == "Real"}

    def units(self, names: Iterable[str]) -> dict[str, str]:
        """Units of variables `fmu.variable`; empty text where the FMU gives none."""
        known = self.variables()
        return {name: known[name].unit or "" if name in known else "" for name in names}

    def setups(self) -> list[FmuSetup]:
        """FMUs and their start values, as a `Master` takes them."""
        return [FmuSetup(name, source, {key: start.given for key, start in self.plan.fmus[name].start.items()},
                         self.ports.get(name)) for name, source in self.sources.items()]

    @property
    def connections(self) -> list[tuple[str, str]]:
        """Return the connections from outputs to inputs, as a `Master` takes them."""
        return list(self.plan.wires.values())

    def run(self, progress: Progress | None = None, complete: Complete = lambda _: None) -> Recording:
        """Run the co-simulation, in a process of its own unless all FMUs are of this project.

        `complete` is called with the recording as soon as that is complete, because an FMU may block its process after
        that.
        """
        descriptions = self.check()
        try:
            recording = self.recorded(descriptions, progress, complete)
        except RunFailed as failure:
            raise after_departure(failure, descriptions, self.connections) from failure
        theirs = {name: described for name, described in descriptions.items() if not self.sources[name].built_here}
        said = [f"at t = {recording.time[k]:.9g} s {text}" for k, text in beyond_ranges(recording, theirs, [
            *self.connections, *((full, full) for full in recording.columns)])]
        return replace(recording, notes=(*recording.notes, *said))

    def recorded(self, descriptions: Mapping[str, ModelDescription], progress: Progress | None,
                 complete: Complete) -> Recording:
        """Return the recording; RunFailed as in `Master`."""
        setups, connections, stop_time = self.setups(), self.connections, self.plan.stop_time
        drives: Drives = self.drives(descriptions)
        apart = [f"{name} ({source.name})" for name, source in self.sources.items() if source.runs_apart]
        if apart:
            for source in self.sources.values():
                if isinstance(source, PythonClass):
                    raise ControllerError(f"{source}: a class runs in this process only, but {apart[0]} was not built "
                                          "by this installation and runs in another one; give the file of the class")
            columns = {full for full, variable in self.variables(descriptions).items()
                       if variable.causality == "output" and variable.type in FMI3.types} | drives.keys()
            return run_apart(IsolatedRun(setups, connections, self.step, self.order, stop_time, drives, self.loop,
                                         frozenset(columns)), progress, self.timeout, complete)
        with Master(setups, connections, self.step, self.order, loop=self.loop) as master:
            master.require_memory(stop_time)
            recording = master.run(stop_time, drives, progress)
        complete(recording)
        return recording

    @property
    def modified(self) -> bool:
        """Return True if the run differs from its plan."""
        return bool(self.changes or self.put_in or self.departures)

    @property
    def fmu_files(self) -> dict[str, Path]:
        """Files of the FMUs by name in the run, without users' classes."""
        return {name: source.path for name, source in self.sources.items() if isinstance(source, FmuFile)}

    @property
    def here(self) -> bool:
        """Return True if it runs in this process alone: a class was given, which no other process knows."""
        return any(isinstance(source, PythonClass) for source in self.sources.values())

    def output_every(self) -> int:
        """Communication steps between two rows of the results."""
        return max(1, round(self.plan.output_interval / self.step))


def prepare(plan: RunPlan, fmus: Path, replaced: Mapping[str, Replacement], settings: Mapping[str, StartValue],
            options: RunOptions | None = None) -> Experiment:
    """Experiment of a run.

    FMUs `replaced`, by name in the run, take the place of those of the plan, which are in the folder `fmus`. Settings
    go before the plan's: start values by `fmu.variable`, or other references by `reference.AXIS.amplitude`. Of the
    options step, order, timeout and a `model` that follows the masses of the plant are read; the rest is in the other
    arguments. ScenarioError or FmuError if a replaced FMU or a setting does not exist or cannot be read, or the run is
    no whole number of steps.
    """
    know_stage_of(plan)
    options = completed_options(options or {})
    step = plan.step if options["step"] is None else float(options["step"])
    with refused_as(ScenarioError, f"{plan.source}: stop_time = {plan.stop_time} s with {option('step', step)}"):
        whole_steps(plan.stop_time, step)
    given = {name: replaced[name].source if name in replaced else
             file_source(str(fmu.file) if fmu.model is None else own_fmu(fmu.model, fmus))
             for name, fmu in plan.fmus.items()}
    sources = {name: source.copy() for name, source in given.items()}
    old = tuple(filter(None, (stale(file.path.stem, copy.path)
                              for file, copy in zip(given.values(), sources.values(), strict=True)
                              if isinstance(file, FmuFile) and isinstance(copy, FmuFile) and file.path.parent == fmus
                              and file.path.stem in known_stages().definitions())))
    put_in, replaced = tuple(replaced), in_place(plan, sources, replaced)
    starts = Starts.planned(plan, replaced, put_in)
    plan = plan.model_copy(update={"signals": [signal for signal in plan.signals if signal.to not in starts.left_out]})
    plan, settings, other_references = with_references(plan, settings)
    settings, fed = without_fed(plan, settings)
    used = [signal.used(plan.stop_time) for signal in plan.signals if isinstance(signal, Csv)]
    overruled = [*(f"{plan.name}: {sentence}" for sentence in dict.fromkeys(filter(None, used))),
                 *([f"{plan.name}: {few(fed)} of parameter sets are left out: the run feeds them"] if fed else []),
                 *starts.ask(plan, settings)]
    plan, starts.given = in_declared_units(plan, of_declared_types(plan, starts.given, sources), sources)
    asked = set(settings)
    model = starts.follow(plan, sources, asked) if str(options["model"]) == "plant" else None
    fitted, notes = fit(with_generated_references(starts.of(plan)), replaced)
    late = needless_delays(plan, options["order"], sources)
    experiment = Experiment(fitted, sources, step, starts.left_out, options["order"],
                            {name: replacement.ports for name, replacement in replaced.items()},
                            (*old, *notes, *overruled, *late), put_in=put_in, timeout=float(options["timeout"]),
                            departures=tuple(departures_of(plan, sources, put_in)), following=model,
                            stale=old,
                            loop=own_loop() if all(isinstance(each, FmuFile) for each in sources.values()) else None)
    return replace(
        experiment, changes=(*other_references, *changes_of(experiment, plan, asked)),
        not_compared=tuple(name for name in plan.check.signals if name not in fitted.check.signals),
        parameter_sets={setting.file: digest_at(Path(setting.file)) for setting in settings.values() if setting.file})


def in_place(plan: RunPlan, sources: Mapping[str, Source], replaced: Mapping[str, Replacement]
             ) -> dict[str, Replacement]:
    """FMUs in the place of the plan's, with their copies and the ports that the plan knows.

    A file that the scenario names is as foreign as one that is asked for: its parameters are its own, too.
    """
    own_files = {name: Replacement(sources[name]) for name, fmu in plan.fmus.items()
                 if fmu.inherited or (fmu.file is not None and sources[name].runs_apart)}
    known_replacements = {}
    for name, replacement in {**own_files, **replaced}.items():
        known_participant(plan, option(name), name)
        known = known_ports(plan, name)
        replacement.ports.require_known(known)
        known_replacements[name] = replace(replacement, source=sources[name],
                                           ports=replace(replacement.ports, units=known))
    return known_replacements


def know_stage_of(plan: RunPlan) -> None:
    """Know the stage of a scenario that names a description, so that each process recognises its FMUs."""
    if plan.stage_file is not None:
        know_stage(plan.stage_file)


def changes_of(experiment: Experiment, plan: RunPlan, asked: Iterable[str]) -> Iterator[str]:
    """Return the settings that differ from the plan, or from the start values of the FMUs: values, step, order."""
    for full in sorted(asked):
        name, _, variable = full.partition(".")
        now, planned = experiment.plan.fmus[name].start[variable], plan.fmus[name].start.get(variable)
        before = known_start(name, experiment.sources[name], variable) if planned is None else planned.given
        if before is None or not same_start(now.given, before) or variable in plan.fmus[name].start_from:
            unit = ""
            with suppress(MaglevError):   # errors are reported when the run is checked
                unit = experiment.units([full])[full]
            former = "" if before is None else f" instead of {with_unit(before, unit)}"
            written = str(now.written) if now.unit or now.text else with_unit(now.value, unit, now.written)
            yield f"{full} = {written}{former}"
    if experiment.step != plan.step:
        yield f"step = {experiment.step} s instead of {plan.step} s"
    if experiment.order != "sequential":
        yield f"order is {experiment.order}"


def with_unit(value: float | str, unit: str, written: object = None) -> str:
    """Return a start value as written, with its unit if it is a number."""
    text = str(value if written is None else written)
    return f"{text} {typeset_unit(unit)}".rstrip() if type(value) in (int, float) else text


def same_start(one: float | str, other: float | str) -> bool:
    """Return True if two start values are the same text, or the same number; Booleans are 0 and 1."""
    return one == other if isinstance(one, str) or isinstance(other, str) else float(one) == float(other)


def after_departure(failure: RunFailed, descriptions: Mapping[str, ModelDescription],
                    connections: Iterable[tuple[str, str]]) -> RunFailed:
    """The failure, after which output was beyond the range of an input that it is connected to, if one was, and when.

    It is the first one.
    """
    departures = beyond_ranges(failure.recording, descriptions, connections)
    if not departures:
        return failure
    k, said = min(departures)
    when = f"at t = {failure.recording.time[k]:.9g} s: "
    return RunFailed(f"{when}{said}; {str(failure).removeprefix(when)}", failure.recording)


def beyond_ranges(recording: Recording, descriptions: Mapping[str, ModelDescription],
                  feeds: Iterable[tuple[str, str]]) -> list[tuple[int, str]]:
    """Return the first value out of range of each connected input: its communication point, and a sentence.

    `feeds` go from recorded signals to inputs. Those of FMUs that have no description here are left out.
    """
    departures = []
    inputs = {f"{name}.{variable.name}": variable for name, description in descriptions.items()
              for variable in description.modelVariables if variable.causality == "input"}
    for source, target in feeds:
        variable, values = inputs.get(target), recording.columns.get(source)
        if variable is None or values is None or (variable.min is None and variable.max is None):
            continue
        low, high = float(variable.min or -np.inf), float(variable.max or np.inf)
        beyond = np.flatnonzero(~((values >= low) & (values <= high)))
        if len(beyond):
            unit = f" {variable.unit}" if variable.unit else ""
            departures.append((int(beyond[0]), f"{source} = {values[beyond[0]]:.9g}{unit} is beyond "
                                               f"{low:g}…{high:g}{unit}, the range of {target}"))
    return departures


def with_generated_references(plan: RunPlan) -> RunPlan:
    """Plan whose axes have as their references the outputs that feed these: an input that is wired is not recorded."""
    sources = {target: source for source, target in plan.wires.values()}
    generated = {name: axis.model_copy(update={"reference": sources[axis.reference]})
                 for name, axis in plan.axes.items() if axis.reference in sources}
    return plan.model_copy(update={"axes": {**plan.axes, **generated}}) if generated else plan


def needless_delays(plan: RunPlan, order: Order, sources: Mapping[str, Source]) -> Iterator[str]:
    """Return sentences about FMUs that are stepped after one that they feed, if another order would avoid the delay.

    In a loop one connection has to run from an FMU to one that is stepped before it. The output of a plant at the end
    of a step is not late. Only FMUs that compute from samples and hold their outputs in between, and ask for a fixed
    step, count.
    """
    def samples(name: str) -> bool:
        return (sources[name].exists
                and not describe(name, sources[name]).coSimulation.canHandleVariableCommunicationStepSize)

    def late(stepped: Sequence[str]) -> int:
        return sum(stepped.index(source) > stepped.index(target) for source, target in wires)

    if order != "sequential":
        return   # every connection is delayed
    names = list(plan.fmus)
    wires = {(source.partition(".")[0], target.partition(".")[0]) for source, target in plan.wires.values()}
    wires = {(source, target) for source, target in wires if source in plan.fmus and target in plan.fmus}
    for source, target in sorted(wires):
        if names.index(source) <= names.index(target):
            continue
        others = [name for name in names if name != source]
        others.insert(others.index(target), source)
        if late(others) < late(names) and samples(source):
            yield (f"{source} is stepped after {target}, which gets its outputs a step of {plan.step:g} s late; "
                   f"before = \"{target}\" under [fmus.{source}] steps it first")
