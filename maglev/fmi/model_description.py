"""modelDescription.xml of a definition (FMI 2.0)."""

from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from xml.etree.ElementTree import Element, SubElement

from maglev.files.fmi_units import DISPLAY_UNITS, exponents
from maglev.fmi.definition import ContinuousModel, FmuDefinition, Variable
from maglev.fmi.parameter_set import xml_file
from maglev.language.errors import ExportError

LICENCE = "MIT"
TOLERANCE = 1e-8   # of a solver, relative

# With the names that FMI proposes (2.0.5, section 2.2.4).
LOG_CATEGORIES = {
    "logStatusWarning": "Messages with status fmi2Warning; there are none",
    "logStatusDiscard": "Messages with status fmi2Discard",
    "logStatusError": "Messages with status fmi2Error, which are logged in any case",
    "logStatusFatal": "Messages with status fmi2Fatal; there are none",
    "logAll": "All messages",
}


def model_description(definition: FmuDefinition, guid: str, version: str, date: int,
                      sources: Sequence[str] = ()) -> bytes:
    """Model description as UTF-8 XML.

    The date, of generation, is in seconds since 1970. An FMU with `sources`, C files, is native; one without runs on
    pythonfmu, in the Python of the importing machine.
    """
    native = bool(sources)
    root = Element("fmiModelDescription", attributes(definition, "2.0", "guid", guid, version, date,
                                                     "ziglang" if native else "pythonfmu"))
    continuous = definition.continuous if native else None
    interfaces = []
    if continuous:
        root.set("numberOfEventIndicators", str(len(continuous.indicators)))
        able = ("canGetAndSetFMUstate", "canSerializeFMUstate", "providesDirectionalDerivative")
        interfaces.append(SubElement(root, "ModelExchange", {
            "modelIdentifier": definition.name, **dict.fromkeys(able, "true")}))   # all others stay false
    interfaces.append(SubElement(root, "CoSimulation", {
        "modelIdentifier": definition.name,
        "needsExecutionTool": xml_boolean(not native),   # Python, which executes the FMU's code (4.3.1)
        "canHandleVariableCommunicationStepSize": xml_boolean(definition.variable_step),
        "canInterpolateInputs": "false",
        "maxOutputDerivativeOrder": "0",
        "canRunAsynchronuously": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": xml_boolean(not native),
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": "false",
    }))
    for interface in interfaces if native else ():
        files = SubElement(interface, "SourceFiles")
        for name in sources:
            SubElement(files, "File", {"name": name})
    table = definition.native_variables if native else definition.variables
    add_common(root, definition, table, LOG_CATEGORIES if native else {}, continuous)   # pythonfmu's messages have none
    variables = SubElement(root, "ModelVariables")
    index = {v.name: number for number, v in enumerate(table, start=1)}
    for reference, variable in enumerate(table):
        scalar = SubElement(variables, "ScalarVariable", common_attributes(variable, reference))
        SubElement(scalar, "Boolean" if variable.boolean else "Real",
                   typed_attributes(definition, variable) | state_attributes(continuous, variable.name, index))
    structure = SubElement(root, "ModelStructure")
    for element, unknowns in structure_of(definition, continuous).items():
        listed = SubElement(structure, element)
        for name, knowns in unknowns.items():
            SubElement(listed, "Unknown", {"index": str(index[name])} | dependencies(knowns, index))
    return xml_file(root)


def attributes(definition: FmuDefinition, fmi: str, key: str, guid: str, version: str, date: int,
               means: str) -> dict[str, str]:
    """Attributes of a model description; `key` is the name of the GUID in this FMI, `means` the tool of the build."""
    return {
        "fmiVersion": fmi,
        "modelName": definition.name,
        key: guid,
        "description": definition.description,
        **({"author": definition.author} if definition.author else {}),
        "version": version,
        **({"copyright": f"Copyright (c) {definition.author}", "license": LICENCE} if definition.author else {}),
        "generationTool": f"Maglev FMUs {version}, {means}",
        "generationDateAndTime": datetime.fromtimestamp(date, UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        "variableNamingConvention": "structured",
    }


def xml_boolean(value: bool) -> str:
    return "true" if value else "false"


def add_common(root: Element, definition: FmuDefinition, variables: Iterable[Variable],
               log_categories: Mapping[str, str], continuous: ContinuousModel | None) -> None:
    """Add the units that occur in the variables, log categories, if there are any, and the default experiment.

    One for model exchange has a tolerance.
    """
    used = sorted({v.unit for v in variables if v.unit})
    units = SubElement(root, "UnitDefinitions") if used else root   # the schema has no empty list
    for name in used:
        unit = SubElement(units, "Unit", {"name": name})
        SubElement(unit, "BaseUnit", {base: str(exponent) for base, exponent in exponents(name).items()})
        if name in DISPLAY_UNITS:
            display, factor = DISPLAY_UNITS[name]
            SubElement(unit, "DisplayUnit", {"name": display, "factor": repr(factor)})
    if log_categories:
        categories = SubElement(root, "LogCategories")
        for name, meaning in log_categories.items():
            SubElement(categories, "Category", {"name": name, "description": meaning})
    SubElement(root, "DefaultExperiment", {
        "startTime": "0.0", "stopTime": repr(definition.experiment.stop_time),
        **({"tolerance": repr(TOLERANCE)} if continuous else {}), "stepSize": repr(definition.experiment.step)})


def state_attributes(continuous: ContinuousModel | None, name: str, reference: Mapping[str, int]) -> dict[str, str]:
    """Attributes of a variable that is the derivative of a state, or a state that jumps at events."""
    states = continuous.states if continuous else ()
    items = [("derivative", str(reference[state.variable])) for state in states if state.derivative == name]
    return dict(items + [("reinit", "true") for state in states if state.variable == name and state.jumps])


def common_attributes(variable: Variable, reference: int) -> dict[str, str]:
    attributes = {"name": variable.name, "valueReference": str(reference), "description": variable.description,
                  "causality": variable.causality, "variability": variable.variability}
    initial = {"output": "calculated", "local": "calculated", "parameter": "exact"}.get(variable.causality)
    return attributes | ({"initial": initial} if initial else {})


def typed_attributes(definition: FmuDefinition, variable: Variable) -> dict[str, str]:
    typed: dict[str, str] = {}
    if variable.causality in ("input", "parameter"):
        start = definition.start_value(variable)
        if not variable.low <= start <= variable.high:
            raise ExportError(f"{definition.name}: {variable.name} starts as {start}, expected a number from "
                              f"{variable.low} to {variable.high}")
        typed["start"] = xml_boolean(bool(start)) if variable.boolean else repr(float(start))
    if variable.unit:
        typed["unit"] = variable.unit
        if variable.unit in DISPLAY_UNITS:
            typed["displayUnit"] = DISPLAY_UNITS[variable.unit][0]
    for key, limit in (("min", variable.minimum), ("max", variable.maximum), ("nominal", variable.nominal)):
        if limit is not None:
            typed[key] = repr(float(limit))
    return typed


def dependencies(knowns: Iterable[str], reference: Mapping[str, int]) -> dict[str, str]:
    """Attribute with the dependencies of an unknown; it names no kind, so that any is possible."""
    return {"dependencies": " ".join(str(number) for number in sorted({reference[name] for name in knowns}))}


def structure_of(definition: FmuDefinition,
                 continuous: ContinuousModel | None) -> dict[str, dict[str, tuple[str, ...]]]:
    """Names of unknowns, each with the names that it depends on, by their element of FMI 2.0."""
    outputs = [v for v in definition.variables if v.causality == "output"]
    unknowns = {"Outputs": {v.name: continuous.outputs[v.name] if continuous else v.depends_on for v in outputs}}
    initial = {v.name: v.starts_from for v in outputs}
    if continuous:
        unknowns["Derivatives"] = {state.derivative: state.depends_on for state in continuous.states}
        # States begin at 0 except for positions. Much decides their rates; it is written out, though to say nothing
        # would
        # say the same: CasADi 3.8.2 reads no FMI 3.0 without it.
        known = tuple(v.name for v in definition.variables if v.causality in ("input", "parameter"))
        initial = {state.derivative: known for state in continuous.states} | {
            state.variable: () for state in continuous.states} | initial
    order = {v.name: number for number, v in enumerate(definition.native_variables)}
    return unknowns | {"InitialUnknowns": dict(sorted(initial.items(), key=lambda item: order[item[0]]))}
