"""Calls of FMI 3.0 in the loops of the master: what fmi3DoStep returns next to its status."""

from ctypes import CFUNCTYPE, c_bool, c_double, c_int, c_uint32, c_void_p
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from facts import raises

from maglev.cosim.fmi_versions import WARNING, Step3
from maglev.cosim.step_loop import Stepper, own_loop
from maglev.cosim.wiring import Call

DO_STEP = CFUNCTYPE(c_uint32, c_void_p, c_double, c_double, c_bool, c_void_p, c_void_p, c_void_p, c_void_p)


@pytest.mark.parametrize("in_c", [True, False])
@pytest.mark.parametrize(("status", "ends", "expected"), [
    (0, False, None), (1, False, None), (0, True, 2), (3, False, 3), (3, True, 3)])
def test_an_fmu_that_asks_for_the_end_ends_the_run(fmi3_fmus: Path, in_c: bool, status: int, ends: bool,
                                                   expected: int | None) -> None:
    """In the third step, with the status that FMI 2.0 has for it, or that of an error."""
    seen: list[tuple[float, float, bool]] = []

    def step(instance: int, time: float, size: float, no_set_before: bool, *places: int) -> int:
        seen.append((time, size, no_set_before))
        third = len(seen) == 3
        c_bool.from_address(places[1]).value = ends and third
        return status if third else 0

    def require(call: str, found: int) -> None:
        if found > WARNING:
            raise RuntimeError(f"{call} {found}")

    said: list[str] = []
    function = Step3(DO_STEP(step), said.append)
    failed: Any = SimpleNamespace(require=require, failed=lambda call, found: RuntimeError(f"{call} {found}"))
    time = c_double()
    call: Any = Call(time, 0.0, 0.5, function, (c_void_p(7), time, c_double(0.5), c_int(1)), (failed, "fmi3DoStep"))
    stepper = Stepper([[call]], own_loop() if in_c else None)
    assert (stepper.loop is not None) is in_c
    if expected is None:
        stepper.step_over(0, 5)
        assert seen == [(0.5 * k, 0.5, True) for k in range(5)]
        return
    with raises(RuntimeError, "fmi3DoStep", expected):
        stepper.step_over(0, 5)
    assert len(seen) == 3
    assert said == (["the FMU asks for the end of the simulation"] if status == 0 else [])
