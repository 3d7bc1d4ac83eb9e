"""A system of FMUs and its connections as an SSP file (System Structure and Parameterization 1.0, or 2.0 with FMI 3.0).

Both versions have the same elements where a system of FMI 2.0 is concerned; 2.0 adds the types of FMI 3.0.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, register_namespace

from maglev.files.fmi_units import exponents
from maglev.fmi.build import write_archive
from maglev.fmi.definition import FmuDefinition, Variable
from maglev.fmi.parameter_set import SSC, SSV, Value, parameter_set, xml_file
from maglev.language.errors import ExportError

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
FMU_TYPE = "application/x-fmu-sharedlibrary"
SSP = {2: "1.0", 3: "2.0"}   # version by that of FMI

# Layout for importers: components side by side in their order, inputs on the left, outputs on the right.
WIDTH, GAP, PITCH = 160.0, 120.0, 10.0   # of a component, between two, and between two connectors

for prefix, namespace in (("ssd", SSD), ("ssc", SSC)):
    register_namespace(prefix, namespace)


def write_ssp(path: Path, components: Mapping[str, tuple[FmuDefinition, Path]], connections: Sequence[tuple[str, str]],
              stop_time: float, ports: bool = True, fmi: int = 2,
              start: Mapping[str, Mapping[str, float | bool]] | None = None) -> Path:
    """Write a system of FMUs; inputs that nothing feeds become inputs of the system, outputs its outputs.

    They keep the names that they have in their FMU: fmpy takes a port of the system that is named `component.variable`
    for the port of the component. An output that is called as a port before it stays within the system.

    Components are, by name in the system and in the order of their steps, the definition of an FMU, and its file.
    Connections go from an output to an input, both `component.variable`. The stop time (s) is that of the default
    experiment. Without `ports` the system has none: ecos and libcosim read no system that has. With FMUs of FMI 3 the
    file is SSP 2.0, and the parameter sets are files of their own. `start` has start values by component, where they
    are not the FMU's. ExportError if two inputs of the system would have the same name.
    """
    contents = {f"resources/{file.name}": file.read_bytes() for _, file in components.values()}
    definitions = {name: definition for name, (definition, _) in components.items()}
    root = Element(f"{{{SSD}}}SystemStructureDescription", {"version": SSP[fmi], "name": path.stem})
    system = SubElement(root, f"{{{SSD}}}System", {"name": path.stem})
    fed = {target for _, target in connections}
    every = [(name, variable) for name, definition in definitions.items() for variable in definition.variables]
    owners: dict[str, str] = {}
    for name, variable in every:
        if (ports and variable.causality == "input" and f"{name}.{variable.name}" not in fed
                and owners.setdefault(variable.name, name) != name):
            raise ExportError(f"{path.name}: {owners[variable.name]} and {name} both have an open input "
                              f"{variable.name}, expected different names")
    outside = [(name, variable) for name, variable in every if ports and (
        (variable.causality == "input" and f"{name}.{variable.name}" not in fed)
        or (variable.causality == "output" and owners.setdefault(variable.name, f"{name}'s") == f"{name}'s"))]
    if outside:
        add_connectors(SubElement(system, f"{{{SSD}}}Connectors"), [variable for _, variable in outside], fmi)
    elements = SubElement(system, f"{{{SSD}}}Elements")
    left = height = 0.0
    for name, (definition, file) in components.items():
        sides = [sum(v.causality == side for v in definition.variables) for side in ("input", "output")]
        box = {"x1": repr(left), "y1": "0.0", "x2": repr(left + WIDTH), "y2": repr(PITCH * (max(sides) + 1))}
        component = SubElement(elements, f"{{{SSD}}}Component", {"name": name, "description": definition.description,
                                                                 "type": FMU_TYPE, "source": f"resources/{file.name}"})
        add_connectors(SubElement(component, f"{{{SSD}}}Connectors"), definition.variables, fmi)
        SubElement(component, f"{{{SSD}}}ElementGeometry", box)
        starts = all_start_values(definition, (start or {}).get(name, {}))
        values = parameter_set(name, starts)
        binding = SubElement(SubElement(component, f"{{{SSD}}}ParameterBindings"), f"{{{SSD}}}ParameterBinding")
        if fmi == 3:
            binding.set("source", f"resources/{name}.ssv")
            add_units(values, SSV, {value.unit for value in starts if value.unit})
            contents[f"resources/{name}.ssv"] = xml_file(values)
        else:
            SubElement(binding, f"{{{SSD}}}ParameterValues").append(values)
        left, height = left + WIDTH + GAP, max(height, PITCH * (max(sides) + 1))
    links = SubElement(system, f"{{{SSD}}}Connections")
    for source, target in connections:
        add_connection(links, source.split(".", 1), target.split(".", 1))
    for name, variable in outside:
        inner, outer = [name, variable.name], [None, variable.name]
        add_connection(links, *((inner, outer) if variable.causality == "output" else (outer, inner)))
    SubElement(system, f"{{{SSD}}}SystemGeometry", {"x1": repr(-GAP), "y1": repr(-GAP), "x2": repr(left),
                                                    "y2": repr(height + GAP)})
    add_units(root, SSD, {v.unit for definition in definitions.values() for v in definition.variables if v.unit})
    SubElement(root, f"{{{SSD}}}DefaultExperiment", {"startTime": "0.0", "stopTime": repr(stop_time)})
    contents["SystemStructure.ssd"] = xml_file(root)
    return write_archive(path, contents)


def add_connectors(connectors: Element, variables: Sequence[Variable], fmi: int) -> None:
    """Add ports with their types and units; inputs and outputs also with their place at the edge of their owner."""
    sides = {side: [v.name for v in variables if v.causality == side] for side in ("input", "output")}
    for variable in variables:
        connector = SubElement(connectors, f"{{{SSD}}}Connector", {"name": variable.name, "kind": variable.causality})
        SubElement(connector, f"{{{SSC}}}{type_of(variable, fmi)}", {"unit": variable.unit} if variable.unit else {})
        if (side := variable.causality) in sides:
            down = (sides[side].index(variable.name) + 1) / (len(sides[side]) + 1)
            SubElement(connector, f"{{{SSD}}}ConnectorGeometry", {"x": "0.0" if side == "input" else "1.0",
                                                                  "y": f"{1.0 - down:.4g}"})


def type_of(variable: Variable, fmi: int) -> str:
    return "Boolean" if variable.boolean else "Real" if fmi == 2 else "Float64"


def all_start_values(definition: FmuDefinition, others: Mapping[str, float | bool]) -> list[Value]:
    """Every start value, those of an FMU and `others` by name: not every tool takes those of the FMU."""
    return [Value(variable.name, type_of(variable, 2), others.get(variable.name, definition.start_value(variable)),
                  variable.unit) for variable in definition.variables if variable.causality != "output"]


def add_connection(links: Element, source: Sequence[str | None], target: Sequence[str | None]) -> None:
    """Add a connection between (component, port) pairs; without a component it is a port of the system."""
    ends = (("startElement", source[0]), ("startConnector", source[1]), ("endElement", target[0]),
            ("endConnector", target[1]))
    SubElement(links, f"{{{SSD}}}Connection", {key: name for key, name in ends if name is not None})


def add_units(root: Element, namespace: str, names: set[str]) -> None:
    """Add the definitions of the units, if any: the file contains everything that it refers to."""
    if not names:
        return
    units = SubElement(root, f"{{{namespace}}}Units")
    for name in sorted(names):
        unit = SubElement(units, f"{{{SSC}}}Unit", {"name": name})
        SubElement(unit, f"{{{SSC}}}BaseUnit", {base: str(exponent) for base, exponent in exponents(name).items()})
