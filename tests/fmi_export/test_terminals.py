"""The plugs of the motors: valid, complete, and the same on the two sides of a connection."""

import re
import zipfile
from pathlib import Path
from xml.etree.ElementTree import fromstring

import fmpy
import pytest
from lxml import etree

from maglev.catalogue import DEFINITIONS, definition

SCHEMA = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
FILE = "terminalsAndIcons/terminalsAndIcons.xml"


def plugs(fmu: Path) -> dict[str, dict[str, str]]:
    """Variables by the names of terminal and member; none if the FMU has no such file."""
    with zipfile.ZipFile(fmu) as archive:
        if FILE not in archive.namelist():
            return {}
        text = archive.read(FILE)
    etree.XMLSchema(etree.parse(str(SCHEMA))).assertValid(etree.fromstring(text))
    terminals = fromstring(text).findall("Terminals/Terminal")
    assert {terminal.attrib["matchingRule"] for terminal in terminals} == {"plug"}
    return {terminal.attrib["name"]: {member.attrib["memberName"]: member.attrib["variableName"]
                                      for member in terminal.iter("TerminalMemberVariable")}
            for terminal in terminals}


@pytest.mark.parametrize("name", DEFINITIONS)
def test_every_motor_that_is_commanded_has_one(either_kind: Path, name: str) -> None:
    found = plugs(either_kind / f"{name}.fmu")
    commands = [v.name for v in definition(name).variables if re.search(r"\.i_[abc]_cmd$", v.name)]
    assert bool(found) is not name.startswith("Estimator")
    assert sorted(variable for members in found.values() for variable in members.values()) == sorted(commands)
    assert all(len(members) == 3 for members in found.values())


@pytest.mark.parametrize("stage", ["2DOF", "3DOF"])
def test_plant_and_controllers_match(fmus: Path, stage: str) -> None:
    """The rule "plug": terminals whose members have the same names."""
    plant = plugs(fmus / f"Plant{stage}.fmu")
    assert set(plant) == ({"motor"} if stage == "2DOF" else {"alpha", "beta"})
    for name in DEFINITIONS:
        if name.endswith(stage) and not name.startswith(("Plant", "Estimator", "ClosedLoop")):
            assert plugs(fmus / f"{name}.fmu") == plant, name
