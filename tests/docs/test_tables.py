"""The tables in pages are those that the tool makes of the code; a few values stand here by themselves."""

import re
import runpy
from pathlib import Path

import pytest

from maglev.files.marked import with_part

ROOT = Path(__file__).parents[2]
TOOL = runpy.run_path(str(ROOT / "tools" / "write_tables.py"))


@pytest.mark.parametrize(("page", "part"), [(page, part) for page, parts in TOOL["PARTS"].items() for part in parts])
def test_the_page_has_the_table(page: str, part: str) -> None:
    path = ROOT / "docs" / page
    made = with_part(path, part, TOOL["PARTS"][page][part]())
    assert made == path.read_text(encoding="utf-8"), "`python tools/write_tables.py` rewrites the tables"


@pytest.mark.parametrize(("page", "row"), [
    ("stages.md", "| 3-DOF | `y` | air gap | 6.9 kg | 25 mm | 18.5 to 32 mm | 1 N | 0.5 mm | 2 N s/m |"),
    ("stages.md", "| 2-DOF | `motor` | 1 | `h` | | 9 A | 7 A | 0.3 ms | 7 Ω | 70 mH |"),
    ("stages.md", "| 3-DOF | `C3` | attraction between magnets and iron (5.3) | 334.52 | 327.5 | m/(s2.T2) |"),
    ("fmi.md", "| co-simulation | `canHandleVariableCommunicationStepSize` | yes | no | no |"),
    ("fmi.md", "| co-simulation | `needsExecutionTool` | no; Python: yes | no; Python: yes | no; Python: yes |")])
def test_values_from_the_thesis_and_from_fmi(page: str, row: str) -> None:
    """Sections 4.1.3, 5.1.3 and Tables 5.1 to 5.3; flags of FMI 2.0.5, section 4.3.1."""
    text = re.sub(" +", " ", (ROOT / "docs" / page).read_text(encoding="utf-8"))
    assert row in text
