"""Whether a user's class comes to an end in every step, as far as its text shows."""

import pytest
from written_controllers import PD

from maglev.user_controllers.subset import always_ends

HOLDER = """
class Inner:
    def step(self) -> float:
        return {inner}

class Outer:
    def __init__(self) -> None:
        self.part = Inner()

    def step(self, t: float) -> float:
        return {outer}
"""


def held(inner: str = "1.0", outer: str = "self.part.step()") -> str:
    """A class with a part, whose step has the name of its own."""
    return HOLDER.format(inner=inner, outer=outer)


@pytest.mark.parametrize(("texts", "ends"), [
    ([PD], True), ([held()], True),
    ([held(inner="helped(2.0)"), "def helped(x: float) -> float:\n    return x\n"], True),
    (["def f(x: float) -> float:\n    for i in range(3):\n        x = x + 1.0\n    return x\n"], True),
    (["def f(x: float) -> float:\n    for i in range(int(x)):\n        x = x + 1.0\n    return x\n"], False),
    (["def f(x: float) -> float:\n    while x > 1.0:\n        x = 0.5 * x\n    return x\n"], False),
    (["def f(x: float) -> float:\n    return f(x - 1.0)\n"], False),
    (["def f(x: float) -> float:\n    return g(x)\n", "def g(x: float) -> float:\n    return f(x)\n"], False),
    ([held(outer="self.command.step(t)") + "        self.command = MotorCommand()\n"], True),   # knows none of these
    ([held(outer="self.command.step(t)") + "        self.command = self.other\n"], False),
    ([held() + "\n    def command(self, step: MotorCommand) -> float:\n        return step.command(self)\n"], True),
    ([held() + "\n    def command(self, step: Outer) -> float:\n        return step.command(self)\n"], False),
    ([held(outer="self.step(t)")], False), ([held(inner="self.step()")], False),
    ([held(outer="Outer().step(t)")], False)])
def test_what_is_seen_to_end(texts: list[str], ends: bool) -> None:
    assert always_ends(texts) == ends
