"""Cost of a study: flights of a scenario on native FMUs as a multiple of the C loop of its blocks, and what Dask adds.

Processor time counts, of all processes: on a machine with other work, wall time says little.
"""

import argparse
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time

from c_loop import c_loop
from distributed import Client
from loops import PAIRS
from rich.console import Console
from rich.table import Table
from speed_history import WHOLE, record

from maglev.api.options import experiments_of
from maglev.catalogue import HOST, build
from maglev.schema.loading import load_plan
from maglev.studies.flying.batches import fly_all
from maglev.studies.flying.cluster import connected
from maglev.studies.flying.samples import Flown, each_flown, gathered
from maglev.studies.planning import PlannedStudy, plan_study
from maglev.studies.schema import read_study

SCENARIO = "3dof-setpoints-improved"
ROUNDS = 5            # of the C loop, of which the fastest counts
EMPTY_TASKS = 500


def planned(folder: Path, samples: int) -> PlannedStudy:
    """A study of so many payloads."""
    study = read_study({"name": "cost", "scenario": SCENARIO, "vary": [
        {"set": "plant.y.mass", "kind": "grid", "from": 6.5, "to": 7.5, "number": samples}]}, Path("cost"))
    experiment, = experiments_of([load_plan(SCENARIO)], {"fmus": folder, "native": True})
    return plan_study(study, experiment, "cost", folder, {})


def flown(study: PlannedStudy, samples: int) -> Flown:
    """So many samples of a study flown in this process."""
    return gathered(study.job, 0, samples, each_flown(study.job, study.values[:samples]))


def processor_times(client: Client) -> float:
    """Processor time of all workers so far, s."""
    def here() -> float:
        times = os.times()
        return times.user + times.system

    return float(sum(client.run(here).values()))


def processor_time(call: Callable[[], object]) -> float:
    """Processor time of a call in this process, s."""
    begin = process_time()
    call()
    return process_time() - begin


def on_cluster(study: PlannedStudy, jobs: int) -> tuple[float, float, float]:
    """Wall time of a study on so many processes, processor time of the workers and of this process, s."""
    with connected(None, jobs) as client:
        # Imports, once in each process.
        fly_all(client, study.job, study.batches[:2 * jobs], study.values, lambda _number, _flown: None)
        workers, here, wall = processor_times(client), process_time(), perf_counter()
        fly_all(client, study.job, study.batches, study.values, lambda _number, _flown: None)
        return perf_counter() - wall, processor_times(client) - workers, process_time() - here


def empty_task(jobs: int) -> float:
    """Wall time that Dask takes for a task that does nothing, s."""
    with connected(None, jobs) as client:
        client.gather(client.map(abs, range(100), pure=False))
        begin = perf_counter()
        client.gather(client.map(abs, range(EMPTY_TASKS), pure=False))
        return (perf_counter() - begin) / EMPTY_TASKS


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=40)
    parser.add_argument("--record", action="store_true", help="add the ratio to the history of this commit")
    asked = parser.parse_args()
    samples: int = asked.samples
    pair = next(pair for pair in PAIRS if pair.plant == "Plant3DOF")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        build([pair.controller, pair.plant], folder / "native", HOST)
        study = planned(folder, samples)
        steps = round(study.job.experiment.plan.stop_time / study.job.experiment.step)
        loop = c_loop(pair, steps)
        assert not any(flown(study, 1).failures)   # with it, what is done once
        alone = processor_time(lambda: flown(study, samples)) / samples
        c = min(processor_time(loop) for _ in range(ROUNDS))
        table = Table("way", "a sample (ms)", "of the C loop", "wall time of all (s)",
                      title=f"{samples} flights of {SCENARIO}, {steps} steps each; C loop {1e3 * c:.1f} ms a flight")
        table.add_row("one process, no Dask: processor time", f"{1e3 * alone:.1f}", f"{alone / c:.2f}", "")
        if asked.record:
            record(WHOLE, {"a sample of a study": alone / c})
        for jobs in (1, 2):
            wall, workers, here = on_cluster(study, jobs)
            table.add_row(f"Dask, {jobs} process{'es' if jobs > 1 else ''}: workers' processor time",
                          f"{1e3 * workers / samples:.1f}", f"{workers / samples / c:.2f}", f"{wall:.2f}")
            table.add_row("and of the process that plans", f"{1e3 * here / samples:.1f}", f"{here / samples / c:.2f}",
                          "")
        Console(width=110).print(table)
        size = study.batches[0].last - study.batches[0].first
        print(f"An empty task takes Dask {1e3 * empty_task(2):.2f} ms; here a task flies {size} samples.")


if __name__ == "__main__":
    main()
