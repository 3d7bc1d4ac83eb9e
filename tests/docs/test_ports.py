"""The page of components and ports has all FMUs, and all ports of those that are no closed loop."""

import re
from pathlib import Path

import pytest

from maglev.descriptions.own_fmus import DEFINITIONS, definition
from maglev.descriptions.packaged import PACKAGED_STAGES

PAGE = (Path(__file__).parents[2] / "docs" / "ports.md").read_text(encoding="utf-8")
OF_TILTS = {"m": "rad", "m/s": "rad/s"}   # units, as the page says
SECTIONS = {"Plant": "Plant", "Controllers": "Regulator LinearRegulator ScheduledRegulator InterpolatedRegulator "
                                             "AdaptiveRegulator PID",
            "Commutation": "Commutation", "Estimator": "Estimator", "Measurement": "Measurement"}


def test_every_fmu_is_named() -> None:
    table = PAGE[PAGE.index("| FMU |"):PAGE.index("## Names")]
    named = set()
    for cell in re.findall(r"^\| (`.*?) \|", table, re.MULTILINE):
        first = ""
        for name in re.findall(r"`(.*?)`", cell):
            first = name if not name.startswith("…") else first
            named.add(re.sub(r"\dDOF", name[1:], first) if name.startswith("…") else name)
    assert named == set(DEFINITIONS)


def rows(section: str) -> list[tuple[str, str, str]]:
    """Name, direction and unit of the ports in the table of a section; the name with its placeholders."""
    text = PAGE.partition(f"\n## {section}\n")[2].partition("\n## ")[0]
    found = []
    for names, direction, units in re.findall(r"^\| (`.*`) \| (in|out) \| (.*?) ?\| ", text, re.MULTILINE):
        ports, given = re.findall(r"`(.*?)`", names), units.split(", ")
        found += [(port, direction, given[min(place, len(given) - 1)]) for place, port in enumerate(ports)]
    return found


@pytest.mark.parametrize("section", SECTIONS)
def test_the_page_has_every_port(section: str) -> None:
    unused = set(rows(section))
    assert unused
    for suffix, stage in ((stage.suffix, stage) for stage in PACKAGED_STAGES.values()):
        expected = {}
        for row in rows(section):
            for axis in stage.axis_names:
                for motor in stage.motor_names:
                    expected[row[0].replace("<axis>", axis).replace("<motor>", motor)] = row
        for kind in SECTIONS[section].split():
            if f"{kind}{suffix}" not in DEFINITIONS:
                continue
            for port in definition(f"{kind}{suffix}").variables:
                if port.causality == "parameter":
                    continue
                row = expected[port.name]
                assert row[1] == {"input": "in", "output": "out"}[port.causality], port.name
                assert row[2] in (port.unit, "") or OF_TILTS.get(row[2]) == port.unit, port.name
                unused.discard(row)
    assert not unused
