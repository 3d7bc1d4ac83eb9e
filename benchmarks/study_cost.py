"""Cost of a study: samples of a scenario on native FMUs as a multiple of the frozen C loop.

By calls of the FMUs, and by the loop with their blocks, also as large studies have it, with metrics. In this thread
processor time counts; of threads and processes side by side, wall time, which says little on a machine with other work.
"""

import argparse
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time
from unittest.mock import patch

from loops import PAIRS
from reference_loop import reference_loop
from rich.console import Console
from rich.table import Table
from speed_history import WHOLE, record

from maglev.api.options import experiments_of
from maglev.catalogue import HOST, build
from maglev.cosim.blocks import block_loop
from maglev.schema.loading import load_plan
from maglev.studies.flying import batches
from maglev.studies.flying.batches import flyers
from maglev.studies.flying.samples import Flown, Job, each_flown, gathered
from maglev.studies.planning import PlannedStudy, plan_study
from maglev.studies.schema import read_study

SCENARIO = "3dof-setpoints-improved"
ROUNDS = 5            # of the C loop, of which the fastest counts


def planned(folder: Path, samples: int) -> PlannedStudy:
    study = read_study({"name": "cost", "scenario": SCENARIO, "vary": [
        {"set": "plant.y.mass", "kind": "grid", "from": 6.5, "to": 7.5, "number": samples}]}, Path("cost"))
    experiment, = experiments_of([load_plan(SCENARIO)], {"fmus": folder, "kind": "native"})
    return plan_study(study, experiment, "cost", folder, {})


def flown(study: PlannedStudy, samples: int, job: Job | None = None) -> Flown:
    job = job or study.job
    return gathered(job, 0, each_flown(job, study.values[:samples]))


def processor_time(call: Callable[[], object]) -> float:
    """Processor time of a call in this process, s."""
    begin = process_time()
    call()
    return process_time() - begin


def side_by_side(study: PlannedStudy, jobs: int) -> float:
    """Wall time of a study in so many threads, s."""
    with flyers(None, jobs) as fly:
        fly(study.job, study.batches[:2 * jobs], study.values, lambda _number, _flown: None)
        begin = perf_counter()
        fly(study.job, study.batches, study.values, lambda _number, _flown: None)
        return perf_counter() - begin


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=80)
    parser.add_argument("--record", action="store_true", help="add the ratio to the history of this commit")
    asked = parser.parse_args()
    samples: int = asked.samples
    pair = next(pair for pair in PAIRS if pair.plant == "Plant3DOF")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        build([pair.controller, pair.plant], folder / "native", HOST)
        study = planned(folder, samples)
        steps = round(study.job.experiment.plan.stop_time / study.job.experiment.step)
        loop = reference_loop(pair, steps)
        assert not any(flown(study, 1).failures)   # with it, what is done once
        c = min(processor_time(loop) for _ in range(ROUNDS))
        table = Table("way", "a sample (ms)", "of the frozen C loop",
                      title=f"{samples} samples of {SCENARIO}, {steps} steps each; frozen C loop "
                            f"{1e3 * c:.1f} ms a sample")

        def row(way: str, time: float) -> None:
            table.add_row(way, f"{1e3 * time:.1f}", f"{time / c:.2f}")

        def alone(job: Job | None = None) -> float:
            return min(processor_time(lambda: flown(study, samples, job)) for _ in range(2)) / samples

        with patch.object(block_loop, "kept", lambda *_: None):   # no loop is found
            row("calls of the FMUs", alone())
        assert batches.loop_for(study.job, study.batches, study.values)   # compiles it
        row("the blocks in one loop", seconds := alone())
        with patch.object(batches, "WORTH_SPECIALISING", 0):
            special = batches.loop_for(study.job, study.batches, study.values)
        row("… with what is common constant", alone(special))
        for jobs in (1, 2):
            row(f"{jobs} side by side: wall time", side_by_side(study, jobs) / samples)
        if asked.record:
            record(WHOLE, {"a sample of a study": seconds / c})
        Console(width=110).print(table)


if __name__ == "__main__":
    main()
