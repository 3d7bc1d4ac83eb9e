"""The smoke test of an FMU: its block from its start values, a few communication steps long."""

from operator import attrgetter

from fmi_export.definition import FmuDefinition
from fmi_export.errors import ExportError
from fmi_export.experiments.files import SMOKE_TEST, ExperimentFiles, tolerances

NAME = "smoke_test"
STEPS = 5
DIGITS = 9   # of the results: the mathematical functions of another machine differ in the last ones


def smoke_test(definition: FmuDefinition) -> ExperimentFiles:
    """What a new block gives at the communication points of its default experiment; ExportError if it refuses."""
    block, step = definition.new_block(), definition.experiment.step
    outputs = {v.name: attrgetter(v.place) for v in definition.variables if v.causality == "output"}
    results: dict[str, list[float]] = {name: [] for name in ("time", *outputs)}
    for k in range(STEPS + 1):
        status = block.start() if k == 0 else block.step((k - 1) * step, step)
        if status:
            raise ExportError(f"{definition.name}: refused its smoke test with status {status}, expected none")
        results["time"].append(k * step)
        for name, value in outputs.items():
            results[name].append(float(f"{float(value(block)):.{DIGITS}g}"))
    nominals = {v.name: v.nominal for v in definition.variables if not v.boolean}
    return ExperimentFiles(NAME, SMOKE_TEST, f"{definition.name} from its start values, {STEPS} communication steps",
                           step, results, tolerances(results, nominals))
