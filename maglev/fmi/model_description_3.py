"""The XML of an FMU of FMI 3.0: modelDescription, buildDescription, terminalsAndIcons."""

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement

import maglev.fmi.model_description as fmi2
from maglev.fmi.definition import SAMPLE_TIME, FmuDefinition, Variable, read
from maglev.fmi.parameter_set import xml_file
from maglev.language.errors import ExportError

FMI = "3.0"

TIME = Variable("time", "independent", "continuous", "Time", "s")
CLOCK = "clock"   # its name

# FMI 3.0's names of the unknowns in an element of FMI 2.0.
ELEMENTS = {"Outputs": "Output", "Derivatives": "ContinuousStateDerivative", "InitialUnknowns": "InitialUnknown"}

OPTIONS = "-O2 -ffp-contract=off -fno-math-errno"   # of gcc and clang

SCALE = 0.1   # mm in a unit of the plane of the icon, in which FMI has it from -100 to 100


def model_description_3(definition: FmuDefinition, token: str, version: str, date: int) -> bytes:
    """Model description as UTF-8 XML, with the instantiation token; for other parameters see `model_description`.

    Variables and value references are those of FMI 2.0; after them comes the time. ExportError if its name is taken.
    """
    root = Element("fmiModelDescription", fmi2.attributes(definition, FMI, "instantiationToken", token, version, date,
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
        "canHandleVariableCommunicationStepSize": fmi2.xml_boolean(clocked or definition.variable_step),
    } | samples | (events if definition.sampled else {}))
    for variable in definition.native_variables:
        if variable.name == TIME.name or (clocked and variable.name == CLOCK):
            raise ExportError(f"{definition.name}: FMI 3.0 has a variable {variable.name} of its own, expected another "
                              "name")
    table = (*definition.native_variables, TIME)
    fmi2.add_common(root, definition, table, fmi2.LOG_CATEGORIES, continuous)
    variables = SubElement(root, "ModelVariables")
    reference = {v.name: number for number, v in enumerate(table)}
    arrays = {reference[array.elements[0]]: array for array in definition.arrays}
    reference |= {name: first for first, array in arrays.items() for name in array.elements}
    ticking = {"variability": "discrete", "clocks": str(len(table))} if clocked else {}
    for number, variable in enumerate(table):
        if reference[variable.name] != number:   # another element of an array
            continue
        described = (fmi2.common_attributes(variable, number) | fmi2.typed_attributes(definition, variable)
                     | fmi2.state_attributes(continuous, variable.name, reference)
                     | (ticking if variable.causality in ("input", "output") else {}))
        if array := arrays.get(number):
            described |= {"name": array.name, "description": array.description}
            if "start" in described:
                elements = table[number:number + len(array.elements)]
                described["start"] = " ".join(fmi2.typed_attributes(definition, v)["start"] for v in elements)
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
    for element, unknowns in fmi2.structure_of(definition, continuous).items():
        if clocked and element == "InitialUnknowns":   # fmpy takes none that are of a clock
            continue
        together: dict[int, set[str]] = {}   # by the reference, of an array or a scalar
        for name, knowns in unknowns.items():
            together.setdefault(reference[name], {""} if clocked else set()).update(knowns)
        for number, known in together.items():
            SubElement(structure, ELEMENTS[element], {"valueReference": str(number)}
                       | fmi2.dependencies(known, reference))
    for name, knowns in continuous.indicators.items() if continuous else ():
        SubElement(structure, "EventIndicator", {"valueReference": str(reference[name])}
                   | fmi2.dependencies(knowns, reference))
    return xml_file(root)


def build_description(name: str, units: Sequence[str]) -> str:
    """How the C files of an FMU are compiled, as XML."""
    root = Element("fmiBuildDescription", {"fmiVersion": FMI})
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
    root = Element("fmiTerminalsAndIcons", {"fmiVersion": FMI})
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
