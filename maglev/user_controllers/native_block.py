"""The block of a user's class for a native FMU: what `SampledBlock` does, as text that pyccel translates."""

from collections.abc import Iterable
from operator import attrgetter
from typing import Any

from fmi_export.user_classes.declaration import WrittenDefinition
from fmi_export.user_classes.sampled_block import FIRST_PORT, STEP_MISFIT, STEPPED

BLOCK = '''"""{name} as a block that is stepped {when}."""

from math import isfinite

from controller_fmu.sample_clock import SampleClock
{imports}


class {name}Block:
    """Steps the law at its samples."""

    def __init__(self) -> None:
        self.law = {name}()
        self.clock = SampleClock()

    def start(self) -> int:
        """Let the law compute what follows from its parameters."""
{start}
        return self.check()

    def step(self, t: float, dt: float) -> int:
        """Step the law{if_due}."""
{step}

    def check(self) -> int:
        """Status of the first output that is no finite number."""
{checks}
        return {stepped}
'''

AT_SAMPLES = f"""\
        if not self.clock.fits(dt, self.law.sample_time):
            return {STEP_MISFIT}
        if self.clock.due(dt, self.law.sample_time):
            self.law.step(t)
            return self.check()
        return {STEPPED}"""
EACH_STEP = """\
        self.law.step(t, dt)
        return self.check()"""


def native_block(definition: WrittenDefinition, law: Any) -> str:
    """Text of a module with the block NAMEBlock; the law is one of the class, of a module with its name in the FMU."""
    ports = [v.place.removeprefix("law.") for v in definition.variables if v.causality == "output" and not v.boolean]
    written = type(law)
    return BLOCK.format(
        name=definition.name, stepped=STEPPED, step=EACH_STEP if definition.variable_step else AT_SAMPLES,
        when="at each communication step" if definition.variable_step else "at its samples",
        if_due="" if definition.variable_step else " if the sampling grid has a point at t",
        imports="\n".join(imports(law, ports)),
        start="        self.law.start()" if hasattr(written, "start") else "        # it computes nothing",
        checks="\n".join(f"        if not isfinite(self.law.{port}):\n            return {number}"
                         for number, port in enumerate(ports, FIRST_PORT)))


def imports(law: Any, ports: Iterable[str]) -> list[str]:
    """Imports of the class and of those of its parts that have outputs, which pyccel has to know."""
    parts = {type(attrgetter(".".join(parts[:depth]))(law)) for port in ports for parts in [port.split(".")]
             for depth in range(1, len(parts))}
    return sorted({f"from {each.__module__} import {each.__name__}" for each in (type(law), *parts)})
