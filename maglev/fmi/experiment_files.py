"""Files of the experiments in an FMU, and the manifest that lists them.

The layered standard FMI-LS-REF is a draft, 1.0.0-beta.1; it lists files and leaves the format of experiments to another
draft, MA-HS-Experiments, whose schema these files follow. Neither says how close a result has to be: the tolerances are
in a file next to the results, as those of the FMI cross-check.
"""

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from xml.etree.ElementTree import Element, SubElement, fromstring, register_namespace

from maglev.fmi.definition import FmuDefinition
from maglev.fmi.parameter_set import Value, parameter_set, xml_file
from maglev.language.errors import ExportError

FOLDER = "extra/org.fmi-standard.fmi-ls-ref/"
MANIFEST = f"{FOLDER}fmi-ls-manifest.xml"
NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
VERSION = "1.0.0-beta.1"
ROOT = {f"{{{NAMESPACE}}}fmi-ls-name": "org.fmi-standard.fmi-ls-ref", f"{{{NAMESPACE}}}fmi-ls-version": VERSION,
        f"{{{NAMESPACE}}}fmi-ls-description":
        "Layered Standard providing information on related files included in an FMU."}

EXPERIMENTS, SSV_TYPE, CSV_TYPE = "application/x-ma-hs-experiments", "application/x-ssp-parameter-set", "text/csv"

SMOKE_TEST, VALIDATION = "experiment/smoke-test", "experiment/validation"

STEPS = 5    # communication steps of a smoke test
DIGITS = 9   # of its results: the mathematical functions of another machine differ in the last ones

RESPONSE, MOST_STEPS = 0.2, 200   # s and communication steps of a response, whichever ends first
ROWS = 20                         # of its results, at most
STEP = 0.01                       # by which an input steps in it, of its nominal value

SHARE = 1e-6   # of the largest value of a result, by which another machine's rounding may change it

register_namespace("fmi-ls", NAMESPACE)


@dataclass(frozen=True)
class ExperimentFiles:
    """An experiment to be put into an FMU."""

    name: str          # of the experiment and, with endings, of its files
    role: str          # `SMOKE_TEST` or `VALIDATION`
    description: str   # in a sentence
    step: float        # communication step, s
    results: Mapping[str, Sequence[float]]            # "time" (s) first, then outputs, SI; Booleans as 0 and 1
    tolerances: Mapping[str, tuple[float, float]]     # of each output: absolute, and relative to the expected value
    inputs: Mapping[str, Sequence[float]] = field(default_factory=dict)   # "time" first; may be empty
    parameters: Sequence[Value] = ()                  # start values that are not those of the FMU, without units

    def files(self) -> dict[str, bytes]:
        times = self.results["time"]
        by_name = {f"{self.name}_ref.csv": csv_table(self.results), f"{self.name}_ref.opt": self.options()}
        root = Element("Experiments", {"name": self.name, "description": self.description})
        experiment = SubElement(root, "Experiment", {"name": self.name, "description": self.description})
        SubElement(experiment, "TransientSimulation", {"startTime": repr(float(times[0])),
                                                       "stopTime": repr(float(times[-1])), "stepSize": repr(self.step)})
        if self.parameters:
            by_name[f"{self.name}.ssv"] = xml_file(parameter_set(self.name, self.parameters))
            SubElement(experiment, "Parameters", {"source": f"{self.name}.ssv"})
        if self.inputs:
            by_name[f"{self.name}_in.csv"] = csv_table(self.inputs)
            SubElement(experiment, "Stimuli", {"source": f"{self.name}_in.csv"})
        SubElement(experiment, "References", {"source": f"{self.name}_ref.csv"})
        return {f"{self.name}.exp": xml_file(root), **by_name}

    def options(self) -> bytes:
        """Times and tolerances, a line for each, as the FMI cross-check has them."""
        times = self.results["time"]
        rows = [("StartTime", times[0]), ("StopTime", times[-1]), ("StepSize", self.step),
                ("OutputInterval", times[1] - times[0])]
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerows((key, repr(float(value))) for key, value in rows)
        for name, tolerance in self.tolerances.items():
            writer.writerows((key, name, f"{value:.3g}") for key, value in zip(("AbsTol", "RelTol"), tolerance,
                                                                             strict=True))
        return text.getvalue().encode()


def smoke_test(definition: FmuDefinition) -> ExperimentFiles:
    """Return the results of a new block in its default experiment; ExportError if it returns a status."""
    about = f"{definition.name} from its start values, {STEPS} communication steps"
    return computed(definition, "smoke_test", SMOKE_TEST, about, STEPS, 1, {})


def response(definition: FmuDefinition) -> ExperimentFiles:
    """Return the results of a new block while its inputs step by a hundredth of their nominal values, one by one.

    Where there are more inputs than steps, some step together. A Boolean changes to its other value. ExportError if the
    block refuses.
    """
    step, block = definition.experiment.step, definition.new_block()
    steps = min(MOST_STEPS, max(STEPS, round(RESPONSE / step)))
    inputs = [v for v in definition.variables if v.causality == "input"]
    columns: dict[str, list[float]] = {}
    for k, variable in enumerate(inputs):
        before, change = float(variable.read(block)), STEP * (variable.nominal or 1.0)
        after = 1.0 - before if variable.boolean else before + (change if before + change <= variable.high else -change)
        at = 1 + k * (steps - 1) // len(inputs)
        columns[variable.name] = at * [before] + (steps - at) * [after]
    return computed(definition, f"{definition.name}_validation", VALIDATION, f"{definition.name} while its inputs step",
                    steps, -(-steps // ROWS), columns)


def computed(definition: FmuDefinition, name: str, role: str, about: str, steps: int, every: int,
             inputs: Mapping[str, Sequence[float]]) -> ExperimentFiles:
    """Return the results of a new block at every `every`-th communication point, with inputs for each step."""
    block, step = definition.new_block(), definition.experiment.step
    outputs = {v.name: v for v in definition.variables if v.causality == "output"}
    fed = [(v, inputs[v.name]) for v in definition.variables if v.name in inputs]
    results: dict[str, list[float]] = {name: [] for name in ("time", *outputs)}
    for k in range(steps + 1):
        status = block.start() if k == 0 else block.step((k - 1) * step, step)
        if status:
            raise ExportError(f"{definition.name}: {name} ends at step {k} with status {status}, expected status 0")
        if k % every == 0:
            results["time"].append(k * step)
            for output, variable in outputs.items():
                results[output].append(float(f"{float(variable.read(block)):.{DIGITS}g}"))
        for variable, values in fed if k < steps else ():
            variable.write(block, bool(values[k]) if variable.boolean else values[k])
    nominals = {v.name: v.nominal for v in definition.variables if not v.boolean}
    return ExperimentFiles(name, role, about, step, results, tolerances(results, nominals), rows_of(definition, inputs))


def rows_of(definition: FmuDefinition, inputs: Mapping[str, Sequence[float]]) -> dict[str, Sequence[float]]:
    """Rows of a file of inputs for each step, "time" (s) first.

    Held inputs have rows only at their changes, half a step early: no rounding error of a clock misses them.
    """
    if not inputs:
        return {}
    step, rows = definition.experiment.step, list(zip(*inputs.values(), strict=True))
    held = not definition.variable_step and all(v.boolean or v.variability in ("discrete", "tunable")
                                                for v in definition.variables if v.name in inputs)
    chosen = [k for k in range(len(rows)) if not held or k == 0 or rows[k] != rows[k - 1]]
    times = [k * step - (step / 2.0 if held and k else 0.0) for k in chosen]
    return {"time": times, **{name: [values[k] for k in chosen] for name, values in inputs.items()}}


def tolerances(results: Mapping[str, Sequence[float]],
               nominals: Mapping[str, float | None]) -> dict[str, tuple[float, float]]:
    """Tolerances of results that are to be repeated except for rounding, absolute and relative by name.

    The absolute one is a share of the largest value, or of the nominal value (1 instead of None) if that is larger.
    Results without a nominal value, such as Booleans, are exact.
    """
    return {name: (SHARE * max(nominals[name] or 1.0, *map(abs, values)) if name in nominals else 0.0, 0.0)
            for name, values in results.items() if name != "time"}


def csv_table(columns: Mapping[str, Sequence[float]]) -> bytes:
    """Columns as CSV; whole numbers, so also Booleans, without a decimal point."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*columns.values(), strict=True):
        writer.writerow(repr(float(value)).removesuffix(".0") for value in row)
    return text.getvalue().encode()


def experiments_files(experiments: Mapping[str, tuple[str, Mapping[str, bytes]]],
                      before: Mapping[str, bytes] | None = None) -> dict[str, bytes]:
    """Files of experiments by name in the FMU, and a manifest that lists them.

    Experiments are, by name, a role and files as in `ExperimentFiles.files`. Entries of the manifest in the files
    `before` stay listed, except for files that others replace.
    """
    new = {f"{FOLDER}{name}": data for _, files in experiments.values() for name, data in files.items()}
    root = Element("fmiReferences", ROOT)
    if before and MANIFEST in before:
        root = fromstring(before[MANIFEST])
        for related in root.findall("Related"):
            if f"{FOLDER}{related.get('source')}" in new:
                root.remove(related)
    place = len(root.findall("Related"))   # annotations come last
    for name, (role, files) in experiments.items():
        description = fromstring(files[f"{name}.exp"]).get("description", name)
        for file in sorted(files):
            kind, own, what = {".exp": (EXPERIMENTS, role, ""), ".ssv": (SSV_TYPE, "parameter", "Parameters: "),
                               ".opt": ("text/plain", "other", "Tolerances of the results: ")}.get(
                PurePosixPath(file).suffix,
                (CSV_TYPE, "result", "Results: ") if file.endswith("_ref.csv") else (CSV_TYPE, "other", "Inputs: "))
            root.insert(place, Element("Related", {"type": kind, "source": file, "role": own,
                                                   "description": f"{what}{description}"}))
            place += 1
    return {MANIFEST: xml_file(root), **new}
