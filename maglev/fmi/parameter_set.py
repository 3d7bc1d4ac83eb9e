"""Values of parameters as an SSV file (System Structure and Parameterization, 1.0 and 2.0 alike)."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement, indent, register_namespace, tostring

from maglev.fmi.escapes import xml_text

SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"   # with the units

register_namespace("ssv", SSV)


class Value(NamedTuple):
    """A parameter: its name, its SSV type ("Real", "Integer" or "Boolean"), its value, and its unit if it has one."""

    name: str
    kind: str
    value: float | bool
    unit: str = ""


def parameter_set(name: str, values: Iterable[Value]) -> Element:
    root = Element(f"{{{SSV}}}ParameterSet", {"version": "1.0", "name": name})
    parameters = SubElement(root, f"{{{SSV}}}Parameters")
    for called, kind, value, unit in values:
        number = int(value) if kind == "Integer" else float(value)
        text = str(bool(value)).lower() if kind == "Boolean" else repr(number)
        parameter = SubElement(parameters, f"{{{SSV}}}Parameter", {"name": called})
        SubElement(parameter, f"{{{SSV}}}{kind}", {"value": text} | ({"unit": unit} if unit else {}))
    return root


def parameters_in(root: Element) -> Iterator[tuple[str, Element | None]]:
    """Names of the parameters of a set, each with the element that has type, value and unit, if there is a value."""
    for parameter in root.iter(f"{{{SSV}}}Parameter"):
        yield parameter.get("name", ""), next((child for child in parameter if child.get("value") is not None), None)


def xml_file(root: Element) -> bytes:
    indent(root)
    text: str = tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{xml_text(text)}\n'.encode()
