"""JUnit XML: counts, reasons, and texts that XML cannot hold as they are."""

from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from maglev.runs.check_outcome import CheckResult, write_junit


def result(name: str, status: Literal["passed", "deviated", "error"], message: str = "") -> CheckResult:
    return CheckResult(name, status, message, None, {}, 1.25)


def test_every_status(tmp_path: Path) -> None:
    path = tmp_path / "new" / "report.xml"
    write_junit(path, [result("good", "passed"), result("moved", "deviated", 'a < b & "c"\x00\x1b[1m'),
                       result("broken", "error", "no file")])
    suite = ElementTree.parse(path).getroot()
    assert (suite.tag, suite.attrib) == ("testsuite", {
        "name": "maglev check", "tests": "3", "failures": "1", "errors": "1", "time": "3.750"})
    cases = suite.findall("testcase")
    assert [case.attrib for case in cases] == [
        {"classname": "maglev.check", "name": name, "time": "1.250"} for name in ("good", "moved", "broken")]
    assert [[reason.tag for reason in case] for case in cases] == [[], ["failure"], ["error"]]
    assert cases[1][0].text == cases[1][0].get("message") == 'a < b & "c"[1m'
    assert [file.name for file in path.parent.iterdir()] == ["report.xml"]


@given(text=st.text(st.characters(codec=None)))
def test_any_text_gives_xml_that_parses(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    path = tmp_path_factory.mktemp("junit") / "report.xml"
    write_junit(path, [result(text, "deviated", text), result(text, "error", text)])
    assert len(ElementTree.parse(path).getroot().findall("testcase")) == 2
