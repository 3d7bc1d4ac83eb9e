"""Runs that start from the results of other runs: their order, and the values that they take over."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from graphlib import CycleError, TopologicalSorter
from typing import Protocol, TypeVar

from maglev.cosim.master import Recording
from maglev.files.errors import Interrupted, ScenarioError
from maglev.files.side_by_side import Stopped, Task, Watcher, kept_processes, side_by_side
from maglev.scenario.run_plan import RunPlan, StartValue

Ends = Mapping[str, Mapping[str, float]]   # every output at the end of a run, by name of the run; empty if it failed


class Ended(Protocol):
    """The result of a run, as far as others start from it."""

    @property
    def ends(self) -> Mapping[str, float]:
        """Every output at the end, empty if the run did not complete."""
        ...


T = TypeVar("T", bound=Ended)


def chained(needs: Mapping[str, set[str]], task: Callable[[str, Ends], Task[T]], jobs: int,
            died: Callable[[str, str], T], watch: Watcher, here: bool = False) -> dict[str, T]:
    """Do the tasks of runs, each after those that it needs, otherwise side by side; return results by name, as in
    `needs`.

    `needs` lists, by name of a run, the runs that it starts from. `task` makes a task of a name and the ends of the
    needed runs. `here` runs them one after the other in this process. See `side_by_side` for the other parameters.
    ScenarioError if runs need each other, or one that does not exist; Interrupted after Ctrl-C or SIGTERM.
    """
    results: dict[str, T] = {}
    with kept_processes() as idle:   # a process takes as long to start as some runs to run
        for ready in waves(needs):
            ends = {name: {other: results[other].ends for other in needs[name]} for name in ready}
            if here:
                results |= {name: task(name, ends[name])(partial(watch, name)) for name in ready}
                continue
            try:
                results |= side_by_side({name: task(name, ends[name]) for name in ready}, jobs, died, watch, idle)
            except Stopped as stopped:
                done = len(results) + len(stopped.results)
                raise Interrupted("; ".join([f"{stopped.what}: {done} of {len(needs)} runs were done",
                                             *(f"{name} {left}" for name, left in stopped.left.items())]),
                                  stopped.number) from None
    return {name: results[name] for name in needs}


def waves(needs: Mapping[str, set[str]]) -> Iterator[list[str]]:
    """Return the runs that can go side by side after those of the waves before; see `chained` for arguments and errors.
    """
    for name, others in needs.items():
        if others - needs.keys():
            raise cannot_go_before(name, *sorted(others - needs.keys()))
    sorter = TopologicalSorter(needs)
    try:
        sorter.prepare()
    except CycleError as error:
        *_, needed, name = error.args[1]   # each of the circle before the one that needs it
        raise cannot_go_before(name, needed) from None
    while sorter.is_active():
        ready = set(sorter.get_ready())
        yield [name for name in needs if name in ready]
        sorter.done(*ready)


def cannot_go_before(name: str, *needed: str) -> ScenarioError:
    return ScenarioError(f"{name}: start_from needs {', '.join(needed)}, expected a run that can go before it")


def ends_of(recording: Recording) -> dict[str, float]:
    """Every output at the end of a run."""
    return {name: float(values[-1]) for name, values in recording.columns.items()}


def started(plan: RunPlan, ends: Ends) -> RunPlan:
    """Plan with the start values that it takes from the ends of other runs; ScenarioError if one did not end."""
    fmus = {}
    for name, fmu in plan.fmus.items():
        taken = {}
        for variable, source in fmu.start_from.items():
            values = ends.get(source.run)
            if not values:
                raise ScenarioError(f"{name}.{variable} starts from {source.output} of {source.run}, which did not "
                                    "complete, or was not run to its end")
            taken[variable] = StartValue(values[source.output], None, values[source.output])
        fmus[name] = fmu.model_copy(update={"start": {**fmu.start, **taken}, "start_from": {}})
    return plan.model_copy(update={"fmus": fmus})
