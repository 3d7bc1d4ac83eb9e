"""The linear model of a measurement: by its transfer function, by its block, and by what it does to a loop."""

from itertools import pairwise
from math import cos, pi

import numpy as np
import pytest
from command_line import error_line, maglev
from facts import raises, require_facts

from maglev.descriptions.own_fmus import definition
from maglev.files.errors import LinearModelError
from maglev.linear.linearise import linearise
from maglev.linear.loop import linearise_loop

STEP = 0.2e-3   # s


@pytest.mark.parametrize("delay", [0.0, STEP, 3.0 * STEP, 2.25 * STEP])
def test_transfer_function_of_a_delay(delay: float) -> None:
    """Of whole samples z⁻ⁿ, which is exp(−jωT); between two samples the straight line between these."""
    model = linearise("Measurement3DOF", {"y": "25 mm"}, parameters={"delay": delay})
    frequencies = np.array([1.0, 100.0, 3000.0])
    z = np.exp(1j * frequencies * STEP)
    whole, fraction = divmod(round(delay / STEP, 9), 1.0)
    expected = (1.0 - fraction) * z ** -whole + fraction * z ** -(whole + 1.0)
    if not fraction:
        assert expected == pytest.approx(np.exp(-1j * frequencies * delay), abs=1e-12)
    assert model.frequency_response(frequencies) == pytest.approx(expected[:, None, None] * np.eye(3), abs=1e-12)
    assert len(model.states) == 3 * np.ceil(round(delay / STEP, 9))


@pytest.mark.parametrize("name", ["Measurement3DOF", "Measurement5DOF"])
def test_what_the_block_does(name: str) -> None:
    """A small step of each encoder, with everything on that is linear, sample by sample."""
    tilts = name.startswith("Measurement5")
    at, part = {"y": 0.025, "x": 1.3e-6}, "alpha2" if tilts else "y"
    given = {"delay": 3.4 * STEP, "x.interpolation.amplitude": 1e-7, "x.interpolation.period": 5e-6, "x.drift": 1e-4,
             f"{part}.offset": 1e-5}
    model, of = linearise(name, at, parameters=given), definition(name)
    ports = {v.name: v for v in of.variables}
    blocks = [of.new_block() for _ in range(2)]
    for block in blocks:
        for key, value in given.items():
            ports[key].write(block, value)
        for encoder in model.inputs:
            ports[encoder].write(block, {"x.encoder": 1.3e-6, "z.encoder": 0.0}.get(encoder, 0.025))
        assert block.start() == 0
        block.sample()
    pushes = np.linspace(1e-10, 2e-10, len(model.inputs))
    for encoder, push in zip(model.inputs, pushes.tolist(), strict=True):
        ports[encoder].write(blocks[1], ports[encoder].read(blocks[1]) + push)
    state = np.zeros(len(model.states))
    for _ in range(7):
        for block in blocks:
            block.sample()
        rest, pushed = (np.array([ports[out].read(block) for out in model.outputs]) for block in blocks)
        assert pushed - rest == pytest.approx(model.C @ state + model.D @ pushes, abs=1e-14)
        state = model.A @ state + model.B @ pushes
    slope = 1.0 + 2.0 * pi * 1e-7 / 5e-6 * cos(2.0 * pi * 1.3e-6 / 5e-6)
    x = model.outputs.index("x.measured")
    assert (pushed - rest)[x] == pytest.approx(slope * pushes[x], rel=1e-6)


@pytest.mark.thorough
@pytest.mark.usefixtures("slow")
def test_a_loop_loses_its_margin_of_delay() -> None:
    """One that measures without delay is the loop without a measurement, also where the platform tilts."""
    for suffix, axis, at in (("3DOF", "y", {"y": 0.025}), ("5DOF", "roll", {"y": 0.025, "roll": 1e-3})):
        names = f"Plant{suffix}", f"Regulator{suffix}"
        plain = vars(linearise_loop(*names, at).margins(axis))
        loops = [linearise_loop(*names, at, measurement=f"Measurement{suffix}",
                                measurement_parameters={"delay": delay}) for delay in (0.0, STEP, 2.0 * STEP)]
        margins = [loop.margins(axis) for loop in loops]
        assert vars(margins[0]) == {name: value if isinstance(value, str) else pytest.approx(value, rel=1e-5)
                                    for name, value in plain.items()}
        if suffix == "3DOF":   # where what is opened is all that is late
            assert [before.delay - after.delay for before, after in pairwise(margins)] == pytest.approx([STEP] * 2,
                                                                                                         rel=1e-3)


@pytest.mark.usefixtures("slow")
def test_command_line_and_what_has_no_linear_model() -> None:
    words = ("linearise", "Plant3DOF", "Measurement3DOF", "Regulator3DOF", "--at", "y=25mm", "--open", "y")
    result = maglev(*words, "--set", "measurement.delay=0.4ms")
    assert result.exit_code == 0, result.output
    loop = linearise_loop("Plant3DOF", "Regulator3DOF", {"y": 0.025}, measurement="Measurement3DOF",
                          measurement_parameters={"delay": 0.4e-3})
    assert f"{1e3 * loop.margins('y').delay:.3g}" in result.output.splitlines()[-1]
    refused = {"measurement.jitter=0.1ms": ["jitter", "0.0001", "0"], "measurement.delay=1": ["delay", "126 samples"],
               "measurement.sample_time=0.1ms": ["sample time"], "measurement.seed=1mm": ["seed", "mm"]}
    for setting, facts in refused.items():
        require_facts(error_line(maglev(*words, "--set", setting)), *facts)
    with raises(LinearModelError, "Measurement3DOF", "hold", 1):
        linearise("Measurement3DOF", {"y": 0.025}, hold=1)
