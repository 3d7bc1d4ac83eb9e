"""The complete example of the page on controllers runs, gives what the page prints, and becomes C."""

import re
from pathlib import Path
from textwrap import dedent

import pytest
from written_blocks import load_module

import maglev
from maglev.language.program import FLOAT
from maglev.language.statements import Program
from maglev.scenario.quantities import printed

PAGE = (Path(__file__).parents[2] / "docs" / "controllers.md").read_text(encoding="utf-8")


@pytest.fixture
def example(tmp_path: Path) -> Path:
    block = re.search(r"^    from math import pi\n(?:    .*\n|\n)+", PAGE, re.MULTILINE)
    assert block is not None
    path = tmp_path / "hold.py"
    path.write_text(dedent(block[0]), encoding="utf-8")
    return path


def test_example_gives_the_errors_of_the_page(example: Path, fastest_fmus: Path) -> None:
    run = maglev.run("2dof-setpoints", controller=example, fmus=fastest_fmus)
    shown = re.findall(r"^    ([vh]) +(\S+ \S+) +(\S+ \S+)$", PAGE, re.MULTILINE)
    assert shown == [(axis, printed(run.metrics.rms_errors[axis], "m"), printed(run.metrics.end_errors[axis], "m"))
                     for axis in "vh"]
    assert run.metrics.stop_contact is None


def test_example_can_be_a_native_fmu(example: Path, tmp_path: Path) -> None:
    program = Program(load_module(tmp_path, example.read_text(encoding="utf-8"), "block.py").Hold())
    assert program.method("step", (FLOAT,)).results == ()
