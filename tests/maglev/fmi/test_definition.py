"""Paths of variables in a block, and the slave's access by them."""

from typing import Any

import pytest
from facts import raises

from maglev.fmi.definition import DefaultExperiment, FmuDefinition, Variable, read, reader, write
from maglev.fmi.slave import BlockSlave


class Part:
    def __init__(self, value: float):
        self.value = value


class Block:
    """Parts in lists, and numbers in a list of a part's."""

    def __init__(self) -> None:
        self.parts = [Part(1.0), Part(2.0)]
        self.rows = [[0.5, 1.5], [2.5, 3.5]]
        self.inner = Part(4.0)
        self.flags = [True, False]

    def start(self) -> int:
        return 0

    def step(self, t: float, dt: float) -> int:
        self.rows[1][0] += dt
        return 0


PATHS = ("parts[1].value", "rows[1][0]", "inner.value")
DEFINITION = FmuDefinition(
    name="Lists", block=Block, description="", refusals={}, experiment=DefaultExperiment(1.0, 0.1), variables=(
        *(Variable(f"v{k}", "parameter", "tunable", "", path=path, minimum=-1e3, maximum=1e3)
          for k, path in enumerate(PATHS)),
        Variable("flag", "parameter", "tunable", "", path="flags[1]", boolean=True)))


@pytest.mark.parametrize(("path", "start"), list(zip(PATHS, (2.0, 2.5, 4.0), strict=True)))
def test_a_path_reads_and_writes_what_python_does(path: str, start: float) -> None:
    block = Block()
    assert read(block, path) == start
    write(block, path, 7.0)
    assert eval(f"block.{path}", {"block": block}) == 7.0
    assert reader([path, "flags[0]"])(block) == (7.0, True)


@pytest.mark.parametrize("path", ["parts[0].value + 1", "parts[-1].value", "__import__('os')", ""])
def test_refuses_a_text_that_is_not_a_path(path: str) -> None:
    with raises(ValueError, repr(path)):
        reader([path])


def test_a_slave_sets_gets_and_saves_elements_of_lists() -> None:
    slave: Any = BlockSlave(DEFINITION, instance_name="lists")
    slave.setup_experiment(0.0)
    slave.enter_initialization_mode()
    slave.set_real([0, 1], [5.0, 6.0])
    slave.set_boolean([3], [True])
    slave.exit_initialization_mode()
    saved = slave._get_fmu_state()
    slave.do_step(0.0, 0.1)
    assert slave.get_real([0, 1, 2]) == [5.0, 6.1, 4.0]
    assert slave.get_boolean([3]) == [True]
    slave._set_fmu_state(saved)
    assert slave.get_real([1]) == [6.0]
