"""The XML of an FMU: modelDescription of FMI 2.0 and 3.0; buildDescription and terminalsAndIcons of 3.0."""

from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from xml.etree.ElementTree import Element, SubElement

from maglev.files.fmi_units import DISPLAY_UNITS, exponents
from maglev.fmi.definition import SAMPLE_TIME, ContinuousModel, FmuDefinition, Variable, read
from maglev.fmi.parameter_set import xml_file
from maglev.language.errors import ExportError

LICENCE = "MIT"
TOLERANCE = 1e-8   # of a solver, relative

# Names that FMI proposes (2.0.5, section 2.2.4).
LOG_CATEGORIES = {
    "logStatusWarning": "Messages with status fmi2Warning; there are none",
    "logStatusDiscard": "Messages with status fmi2Discard",
    "logStatusError": "Messages with status fmi2Error, which are logged in any case",
    "logStatusFatal": "Messages with status fmi2Fatal; there are none",
    "logAll": "All messages",
}

TIME = Variable("time", "independent", "continuous", "Time", "s")
CLOCK = "clock"   # its name

# FMI 3.0's names of the unknowns in an element of FMI 2.0.
ELEMENTS = {"Outputs": "Output", "Derivatives": "ContinuousStateDerivative", "InitialUnknowns": "InitialUnknown"}

OPTIONS = "-O2 -ffp-contract=off -fno-math-errno"   # of gcc and clang

SCALE = 0.1   # mm in a unit of the plane of the icon, in which FMI has it from -100 to 100


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


def model_description_3(definition: FmuDefinition, token: str, version: str, date: int) -> bytes:
    """Model description as UTF-8 XML, with the instantiation token; for other parameters see `model_description`.

    Variables and value references are those of FMI 2.0; after them comes the time. ExportError if its name is taken.
    """
    root = Element("fmiModelDescription", attributes(definition, "3.0", "instantiationToken", token, version, date,
                                                     "ziglang"))
    continuous = definition.continuous
    common = {"modelIdentifier": definition.name, "needsExecutionTool": "false",
              "canBeInstantiatedOnlyOncePerProcess": "false", "canGetAndSetFMUState": "true",
              "canSerializeFMUState": "true"}
    if continuous:
        SubElement(root, "ModelExchange", common | {
            "providesDirectionalDerivatives": "true", "providesAdjointDerivatives": "true",
            "needsCompletedIntegratorStep": "true"})
    clocked = definition.sampled and definition.clocked
    events = {"hasEventMode": "true"} | ({} if clocked else {"mightReturnEarlyFromDoStep": "true"})
    samples = {"fixedInternalStepSize": repr(float(read(definition.new_block(), definition.sampling)))} if (
        definition.sampling and not clocked) else {}
    SubElement(root, "CoSimulation", common | {
        "canHandleVariableCommunicationStepSize": xml_boolean(clocked or definition.variable_step),
    } | samples | (events if definition.sampled else {}))
    for variable in definition.native_variables:
        if variable.name == TIME.name or (clocked and variable.name == CLOCK):
            raise ExportError(f"{definition.name}: FMI 3.0 has a variable {variable.name} of its own, expected another "
                              "name")
    table = (*definition.native_variables, TIME)
    add_common(root, definition, table, LOG_CATEGORIES, continuous)
    variables = SubElement(root, "ModelVariables")
    reference = {v.name: number for number, v in enumerate(table)}
    arrays = {reference[array.elements[0]]: array for array in definition.arrays}
    reference |= {name: first for first, array in arrays.items() for name in array.elements}
    ticking = {"variability": "discrete", "clocks": str(len(table))} if clocked else {}
    for number, variable in enumerate(table):
        if reference[variable.name] != number:   # another element of an array
            continue
        described = (common_attributes(variable, number) | typed_attributes(definition, variable)
                     | state_attributes(continuous, variable.name, reference)
                     | (ticking if variable.causality in ("input", "output") else {}))
        if array := arrays.get(number):
            described |= {"name": array.name, "description": array.description}
            if "start" in described:
                elements = table[number:number + len(array.elements)]
                described["start"] = " ".join(typed_attributes(definition, v)["start"] for v in elements)
        entry = SubElement(variables, "Boolean" if variable.boolean else "Float64", described)
        for size in array.shape if array else ():
            SubElement(entry, "Dimension", {"start": str(size)})
    if clocked:
        reference[""] = len(table)
        SubElement(variables, "Clock", {
            "name": CLOCK, "valueReference": str(reference[""]),
            "description": f"Ticks every {SAMPLE_TIME}, first at the start time",
            "causality": "input", "variability": "discrete", "intervalVariability": "fixed"})
    structure = SubElement(root, "ModelStructure")
    for element, unknowns in structure_of(definition, continuous).items():
        if clocked and element == "InitialUnknowns":   # fmpy takes none that are of a clock
            continue
        together: dict[int, set[str]] = {}   # by the reference, of an array or a scalar
        for name, knowns in unknowns.items():
            together.setdefault(reference[name], {""} if clocked else set()).update(knowns)
        for number, known in together.items():
            SubElement(structure, ELEMENTS[element], {"valueReference": str(number)}
                       | dependencies(known, reference))
    for name, knowns in continuous.indicators.items() if continuous else ():
        SubElement(structure, "EventIndicator", {"valueReference": str(reference[name])}
                   | dependencies(knowns, reference))
    return xml_file(root)


def build_description(name: str, units: Sequence[str]) -> str:
    """How the C files of an FMU are compiled, as XML."""
    root = Element("fmiBuildDescription", {"fmiVersion": "3.0"})
    configuration = SubElement(root, "BuildConfiguration", {
        "modelIdentifier": name, "description": "-ffp-contract=off gives the bits of the binaries, -ffast-math not"})
    files = SubElement(configuration, "SourceFileSet", {"language": "C99", "compilerOptions": OPTIONS})
    for unit in units:
        SubElement(files, "SourceFile", {"name": unit})
    SubElement(files, "PreprocessorDefinition", {
        "name": "FMI3_OVERRIDE_FUNCTION_PREFIX", "optional": "true",
        "description": "For a shared library: the functions of FMI under their own names"})
    SubElement(configuration, "Library", {
        "name": "m", "external": "true", "description": "For square roots alone, where a compiler sets errno by them"})
    return xml_file(root).decode("utf-8")


def terminals_and_icons(definition: FmuDefinition) -> bytes:
    """The icon, and the inputs and outputs of each axis and motor as a terminal.

    A terminal is a bus: members of the same names belong together, such as the currents that a controller commands
    and a plant takes.
    """
    root = Element("fmiTerminalsAndIcons", {"fmiVersion": "3.0"})
    picture = SubElement(root, "GraphicalRepresentation")
    place = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    SubElement(picture, "CoordinateSystem", place | {"suggestedScalingFactorTo_mm": repr(SCALE)})
    SubElement(picture, "Icon", place)
    groups: dict[str, list[Variable]] = {}   # by the part of the block
    elements = {name for array in definition.arrays for name in array.elements}
    for variable in definition.variables:
        if variable.causality in ("input", "output") and "." in variable.name and variable.name not in elements:
            groups.setdefault(variable.name.rpartition(".")[0], []).append(variable)
    if groups:
        terminals = SubElement(root, "Terminals")
        for name, members in groups.items():
            terminal = SubElement(terminals, "Terminal", {"name": name, "matchingRule": "bus"})
            for member in members:
                SubElement(terminal, "TerminalMemberVariable", {
                    "variableName": member.name, "memberName": member.name.rpartition(".")[2],
                    "variableKind": "signal"})
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
    if continuous and (missing := [v.name for v in outputs if v.name not in continuous.outputs]):
        raise ExportError(f"{definition.name}: the output {missing[0]} names no states and inputs on which it depends, "
                          "expected them in `ContinuousModel.outputs`")
    unknowns = {"Outputs": {v.name: continuous.outputs[v.name] if continuous else v.depends_on for v in outputs}}
    initial = {v.name: v.starts_from for v in outputs}
    if continuous:
        unknowns["Derivatives"] = {state.derivative: state.depends_on for state in continuous.states}
        # States begin at 0 except for positions. Much decides their rates; it is written out, though to say nothing
        # would say the same: CasADi 3.8.2 reads no FMI 3.0 without it.
        known = tuple(v.name for v in definition.variables if v.causality in ("input", "parameter"))
        initial = {state.derivative: known for state in continuous.states} | {
            state.variable: () for state in continuous.states} | initial
    order = {v.name: number for number, v in enumerate(definition.native_variables)}
    return unknowns | {"InitialUnknowns": dict(sorted(initial.items(), key=lambda item: order[item[0]]))}
