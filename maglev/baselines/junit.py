"""Results of a check as JUnit XML, which continuous-integration servers show."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from maglev_files.whole_file import whole_file

if TYPE_CHECKING:
    from maglev.baselines.outcome import CheckResult

# Everything but the characters of XML 1.0, section 2.2: no parser accepts the rest, escaped or not.
NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

ELEMENTS = {"deviated": "failure", "error": "error"}


def write_junit(path: Path, results: "Sequence[CheckResult]") -> None:
    """Write one test case for each run; a deviation is a failure, what could not be checked an error.

    The file appears under its name when it is complete.
    """
    statuses = [result.status for result in results]
    suite = ElementTree.Element("testsuite", {
        "name": "maglev check", "tests": str(len(results)), "failures": str(statuses.count("deviated")),
        "errors": str(statuses.count("error")), "time": f"{sum(result.elapsed for result in results):.3f}"})
    for result in results:
        case = ElementTree.SubElement(suite, "testcase", {
            "classname": "maglev.check", "name": printable(result.name), "time": f"{result.elapsed:.3f}"})
        if result.status in ELEMENTS:
            message = printable(result.message)
            reason = ElementTree.SubElement(case, ELEMENTS[result.status], {"message": message, "type": result.status})
            reason.text = message
    ElementTree.indent(suite)
    with whole_file(path) as unfinished:
        ElementTree.ElementTree(suite).write(unfinished, encoding="utf-8", xml_declaration=True)


def printable(text: str) -> str:
    """The text without characters that XML cannot hold."""
    return NO_XML.sub("", text)
