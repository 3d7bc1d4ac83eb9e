"""A system of FMUs and its connections as an SSP file (System Structure and Parameterization 1.0)."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, register_namespace

from fmi_export.build import write_archive
from fmi_export.definition import FmuDefinition, Variable
from fmi_export.errors import ExportError
from fmi_export.parameter_set import Value, parameter_set, xml_file
from fmi_export.units import exponents

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
FMU_TYPE = "application/x-fmu-sharedlibrary"

for prefix, namespace in (("ssd", SSD), ("ssc", SSC)):
    register_namespace(prefix, namespace)


def write_ssp(path: Path, components: Mapping[str, tuple[FmuDefinition, Path]], connections: Sequence[tuple[str, str]],
              stop_time: float, ports: bool = True) -> Path:
    """Write a system of FMUs; inputs that nothing feeds become inputs of the system, all outputs its outputs.

    They keep the names that they have in their FMU: fmpy takes a port of the system that is named `component.variable`
    for the port of the component.

    Parameters
    ----------
    path : Path
        The SSP file.
    components : mapping of str to (FmuDefinition, Path)
        By name in the system, in the order in which they should step: what the FMU is, and its file.
    connections : sequence of (str, str)
        From an output to an input, both `component.variable`.
    stop_time : float
        Of the default experiment, s.
    ports : bool
        Whether the system has ports of its own: ecos and libcosim read no system that has.

    Raises
    ------
    ExportError
        If two ports of the system have the same name.
    """
    contents = {f"resources/{file.name}": file.read_bytes() for _, file in components.values()}
    definitions = {name: definition for name, (definition, _) in components.items()}
    root = Element(f"{{{SSD}}}SystemStructureDescription", {"version": "1.0", "name": path.stem})
    system = SubElement(root, f"{{{SSD}}}System", {"name": path.stem})
    fed = {target for _, target in connections}
    outside = [(name, variable) for name, definition in definitions.items() for variable in definition.variables
               if ports and (variable.causality == "output"
                             or (variable.causality == "input" and f"{name}.{variable.name}" not in fed))]
    if outside:
        connectors = SubElement(system, f"{{{SSD}}}Connectors")
    owners: dict[str, str] = {}
    for name, variable in outside:
        if owners.setdefault(variable.name, name) != name:
            raise ExportError(f"{path.name}: {owners[variable.name]} and {name} both have an open port "
                              f"{variable.name}, expected different names")
        add_connector(connectors, variable.name, variable)
    elements = SubElement(system, f"{{{SSD}}}Elements")
    for name, (definition, file) in components.items():
        add_component(elements, name, definition, file)
    links = SubElement(system, f"{{{SSD}}}Connections")
    for source, target in connections:
        add_connection(links, source.split(".", 1), target.split(".", 1))
    for name, variable in outside:
        inner, outer = [name, variable.name], [None, variable.name]
        add_connection(links, *((inner, outer) if variable.causality == "output" else (outer, inner)))
    add_units(root, {v.unit for definition in definitions.values() for v in definition.variables if v.unit})
    SubElement(root, f"{{{SSD}}}DefaultExperiment", {"startTime": "0.0", "stopTime": repr(stop_time)})
    contents["SystemStructure.ssd"] = xml_file(root)
    return write_archive(path, contents)


def add_connector(connectors: Element, name: str, variable: Variable) -> None:
    """Add a port with its type and unit."""
    connector = SubElement(connectors, f"{{{SSD}}}Connector", {"name": name, "kind": variable.causality})
    if variable.boolean:
        SubElement(connector, f"{{{SSC}}}Boolean")
    else:
        SubElement(connector, f"{{{SSC}}}Real", {"unit": variable.unit} if variable.unit else {})


def add_component(elements: Element, name: str, definition: FmuDefinition, file: Path) -> None:
    """Add an FMU with its ports, and with every start value: not every tool takes those of the FMU."""
    component = SubElement(elements, f"{{{SSD}}}Component", {
        "name": name, "description": definition.description, "type": FMU_TYPE, "source": f"resources/{file.name}"})
    connectors = SubElement(component, f"{{{SSD}}}Connectors")
    for variable in definition.variables:
        add_connector(connectors, variable.name, variable)
    binding = SubElement(SubElement(component, f"{{{SSD}}}ParameterBindings"), f"{{{SSD}}}ParameterBinding")
    values = SubElement(binding, f"{{{SSD}}}ParameterValues")
    values.append(parameter_set(name, (
        Value(variable.name, "Boolean" if variable.boolean else "Real", definition.start_value(variable), variable.unit)
        for variable in definition.variables if variable.causality != "output")))


def add_connection(links: Element, source: Sequence[str | None], target: Sequence[str | None]) -> None:
    """Add a connection between (component, port) pairs; without a component it is a port of the system."""
    ends = (("startElement", source[0]), ("startConnector", source[1]), ("endElement", target[0]),
            ("endConnector", target[1]))
    SubElement(links, f"{{{SSD}}}Connection", {key: name for key, name in ends if name is not None})


def add_units(root: Element, names: set[str]) -> None:
    """Add the definitions of the units."""
    units = SubElement(root, f"{{{SSD}}}Units")
    for name in sorted(names):
        unit = SubElement(units, f"{{{SSC}}}Unit", {"name": name})
        SubElement(unit, f"{{{SSC}}}BaseUnit", {base: str(exponent) for base, exponent in exponents(name).items()})
