"""Blocks in JavaScript: what is translated, and that laws find the parts that they are made of."""

import re
from pathlib import Path

import pytest
from command_line import maglev
from facts import raises

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.errors import ControllerError
from maglev.pages.javascript import law_text, module_in_javascript, parts_text, python_law
from maglev.user.new_controller import new_controller

SOURCE = '''"""A module."""

from math import pi, sqrt

LIMIT = 2.0 * pi   # rad


class Part:
    """A part."""

    inputs = {"y.measured": "m"}

    def __init__(self, gain: float) -> None:
        self.gain = gain    # parameter

    def step(self, t: float, on: bool) -> tuple[float, float]:
        """Take a step."""
        part = Part(-(1.0 - t))
        if not on or 0.0 <= t < LIMIT:
            root = sqrt(t)
        elif t != 0.0:
            root = part.gain - (t - 1.0) / (t / 2.0)
        else:
            return 0.0, 1.0
        # Three times.
        for k in range(3):
            self.gain += root if on else t
        a, self.gain = part.step(t, not on)
        return a, root
'''
EXPECTED = '''const LIMIT = 2.0 * Math.PI; // rad

/** A part. */
class Part {
  static inputs = {"y.measured": "m"};

  constructor(gain) {
    this.gain = gain; // parameter
  }

  /** Take a step. */
  step(t, on) {
    let root;
    let part = new Part(-(1.0 - t));
    if (!on || 0.0 <= t && t < LIMIT) {
      root = Math.sqrt(t);
    } else if (t !== 0.0) {
      root = part.gain - (t - 1.0) / (t / 2.0);
    } else {
      return [0.0, 1.0];
    }
    // Three times.
    for (let k = 0; k < 3; k++) {
      this.gain += on ? root : t;
    }
    [a, this.gain] = part.step(t, !on);
    return [a, root];
  }
}
'''


def test_a_block_is_translated_as_it_reads() -> None:
    text = SOURCE.replace("        a, self.gain = part", "        a = 0.0\n        a, self.gain = part")
    expected = EXPECTED.replace("    [a, this.gain] = part", "    let a = 0.0;\n    [a, this.gain] = part")
    assert module_in_javascript(text) == expected


@pytest.mark.parametrize("line", ["x = 2.0 ** t"])
def test_refuses_syntax_that_blocks_do_not_have(line: str) -> None:
    with raises(ControllerError, "JavaScript"):
        module_in_javascript(f'"""M."""\n\n\nclass A:\n    def step(self, t):\n        {line}\n')


def test_a_law_finds_its_parts_of_which_each_is_there_once() -> None:
    parts = parts_text(map(python_law, PACKAGED_STAGES.values()))
    defined = re.findall(r"^(?:class|function|const) (\w+)", parts, re.MULTILINE)
    assert len(defined) == len(set(defined))
    for stage in PACKAGED_STAGES.values():
        law = law_text(stage)
        own = set(re.findall(r"^(?:class|function|const) (\w+)", law, re.MULTILINE))
        used = set(re.findall(r"new (\w+)", law)) | set(re.findall(r"(?<![\w.])([a-z]\w+)\(", law)) - {"if"}
        assert used - own - {"constructor", "start", "step", "demand", "integrate", "drive"} <= set(defined)
        assert not own & set(defined)
        assert all(f'"{motor}.i_a_cmd"' in law for motor in stage.motor_names)


@pytest.mark.usefixtures("slow")
def test_a_controller_of_ones_own_becomes_a_module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    new_controller("lqi.py", "2dof")
    done = maglev("build", "lqi.py", "Commutation2DOF", "--kind", "native", "--target", "wasm")
    assert done.exit_code == 0, done.output
    assert sorted(path.name for path in Path("fmus/wasm").iterdir()) == [
        "Commutation2DOF.wasm", "Commutation2DOF.xml", "LQI.wasm", "LQI.xml"]
    assert 'name="motor.i_a_cmd"' in Path("fmus/wasm/LQI.xml").read_text(encoding="utf-8")
