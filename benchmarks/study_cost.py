"""Cost of a study: flights of a scenario on native FMUs as a multiple of the frozen C loop.

Processor time counts in one process; of several, wall time, which says little on a machine with other work.
"""

import argparse
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time

from loops import PAIRS
from reference_loop import reference_loop
from rich.console import Console
from rich.table import Table
from speed_history import WHOLE, record

from maglev.api.options import experiments_of
from maglev.catalogue import HOST, build
from maglev.schema.loading import load_plan
from maglev.studies.flying.batches import flyers
from maglev.studies.flying.samples import Flown, each_flown, gathered
from maglev.studies.planning import PlannedStudy, plan_study
from maglev.studies.schema import read_study

SCENARIO = "3dof-setpoints-improved"
ROUNDS = 5            # of the C loop, of which the fastest counts


def planned(folder: Path, samples: int) -> PlannedStudy:
    """A study of so many payloads."""
    study = read_study({"name": "cost", "scenario": SCENARIO, "vary": [
        {"set": "plant.y.mass", "kind": "grid", "from": 6.5, "to": 7.5, "number": samples}]}, Path("cost"))
    experiment, = experiments_of([load_plan(SCENARIO)], {"fmus": folder, "kind": "native"})
    return plan_study(study, experiment, "cost", folder, {})


def flown(study: PlannedStudy, samples: int) -> Flown:
    """So many samples of a study flown in this process."""
    return gathered(study.job, 0, samples, each_flown(study.job, study.values[:samples]))


def processor_time(call: Callable[[], object]) -> float:
    """Processor time of a call in this process, s."""
    begin = process_time()
    call()
    return process_time() - begin


def side_by_side(study: PlannedStudy, jobs: int) -> float:
    """Wall time of a study in so many processes, s, once they have imported what they need."""
    with flyers(None, jobs) as fly:
        fly(study.job, study.batches[:2 * jobs], study.values, lambda _number, _flown: None)
        begin = perf_counter()
        fly(study.job, study.batches, study.values, lambda _number, _flown: None)
        return perf_counter() - begin


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
        loop = reference_loop(pair, steps)
        assert not any(flown(study, 1).failures)   # with it, what is done once
        alone = processor_time(lambda: flown(study, samples)) / samples
        c = min(processor_time(loop) for _ in range(ROUNDS))
        table = Table("way", "a sample (ms)", "of the frozen C loop", "wall time of all (s)",
                      title=f"{samples} flights of {SCENARIO}, {steps} steps each; frozen C loop "
                            f"{1e3 * c:.1f} ms a flight")
        table.add_row("one process: processor time", f"{1e3 * alone:.1f}", f"{alone / c:.2f}", "")
        if asked.record:
            record(WHOLE, {"a sample of a study": alone / c})
        for jobs in (1, 2):
            wall = side_by_side(study, jobs)
            table.add_row(f"{jobs} process{'es' if jobs > 1 else ''} beside this one: wall time",
                          f"{1e3 * wall / samples:.1f}", f"{wall / samples / c:.2f}", f"{wall:.2f}")
        Console(width=110).print(table)


if __name__ == "__main__":
    main()
