"""terminalsAndIcons.xml: variables that belong to one plug (FMI 3.0, section 2.4.9; in FMI 2.0 from 2.0.4 on)."""

from xml.etree.ElementTree import Element, SubElement, indent, tostring

from fmi_export.definition import FmuDefinition

PHASES = ("i_a_cmd", "i_b_cmd", "i_c_cmd")


def terminals(definition: FmuDefinition) -> bytes | None:
    """Terminals as UTF-8 XML: the three phase currents that each motor is commanded; None if there is no motor.

    Those of a controller and of a plant are plugs that match: terminals and members have the same names.
    """
    ports = {v.name for v in definition.variables if v.causality in ("input", "output")}
    motors = [name.removesuffix(f".{PHASES[0]}") for name in sorted(ports) if name.endswith(f".{PHASES[0]}")]
    if not motors:
        return None
    root = Element("fmiTerminalsAndIcons", {"fmiVersion": "3.0"})   # of the schema, for there is none of FMI 2.0
    plugs = SubElement(root, "Terminals")
    for motor in motors:
        plug = SubElement(plugs, "Terminal", {"name": motor, "matchingRule": "plug",
                                              "description": f"phase currents that motor {motor} is commanded"})
        for phase in PHASES:
            SubElement(plug, "TerminalMemberVariable", {"variableName": f"{motor}.{phase}", "memberName": phase,
                                                        "variableKind": "signal"})
    indent(root)
    text: str = tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()
