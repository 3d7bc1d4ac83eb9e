"""The two limitations of section 5.6.2, on the FMU of the 3-DOF plant with the mover held by huge masses."""

from collections.abc import Callable

import numpy as np
import pytest
from fmu_access import put, read
from stage_cases import phases

from maglev.cosim.fmu import Fmu

Load = Callable[[str], Fmu]


def held(load: Load, displacement: float) -> Fmu:
    """Plant without magnetic forces and with huge masses: what counts here is x, which stays."""
    plant = load("Plant3DOF")
    plant.initialise({"y.mass": 1e6, "x.mass": 1e6, "y.position_start": 25e-3, "x.position_start": displacement,
                      "x.bias": 0.0, "C3": 0.0, "C4": 0.0, "C5": 0.0, "C1": 0.0}, 0.0, 100.0)
    return plant


def command(plant: Fmu, i_d: float, i_q: float, displacement: float) -> None:
    put(plant, {f"alpha.i_{phase}_cmd": float(i) for phase, i in zip("abc", phases(i_d, i_q, displacement),
                                                                   strict=True)})


def delivered(plant: Fmu, time: float, step: float, start: float = 0.0) -> tuple[float, float]:
    """i_d and i_q after a time."""
    for k in range(round(time / step)):
        plant.instance.doStep(start + k * step, step)
    return read(plant, "alpha.i_d"), read(plant, "alpha.i_q")


def test_one_current_alone_saturates(load_fastest: Load) -> None:
    """8 A commanded: 5 to 6.7 A at once, by the angle, and 4 to 5.3 A after seconds."""
    at_once, settled = [], []
    for displacement in np.linspace(0.0, 57.15e-3, 14):
        for axis in (0, 1):
            plant = held(load_fastest, float(displacement))
            # The gap falls freely meanwhile, within its stops: only the currents are looked at.
            command(plant, 8.0 * (1 - axis), 8.0 * axis, float(displacement))
            at_once.append(delivered(plant, 2e-3, 2e-3)[axis])
            assert read(plant, "alpha.saturated")
            settled.append(delivered(plant, 4.0, 0.02, 2e-3)[axis])
    assert 5.0 <= min(at_once) < max(at_once) - 0.2
    assert max(at_once) <= 6.7
    assert 4.0 <= min(settled) < max(settled) - 0.1
    assert max(settled) <= 16.0 / 3.0 + 1e-6   # 5.3 A: one phase at 4 A and two at −4 A


@pytest.mark.parametrize(("displacement", "i_d"), [(0.0, 2.00), (9.5e-3, 1.60)])
def test_direct_current_drops_under_a_large_quadrature_current(load_fastest: Load, displacement: float,
                                                               i_d: float) -> None:
    plant = held(load_fastest, displacement)
    command(plant, 2.0, 0.0, displacement)
    assert delivered(plant, 2e-3, 2e-4)[0] == pytest.approx(2.0, abs=1e-6)
    command(plant, 2.0, 6.0, displacement)
    assert delivered(plant, 4e-3, 2e-4, 2e-3)[0] == pytest.approx(i_d, abs=0.005)


def test_continuous_limit(load_fastest: Load) -> None:
    """A phase that is commanded 8 A delivers the peak for two seconds and the continuous current later."""
    plant = held(load_fastest, 0.0)
    put(plant, {"beta.i_a_cmd": 8.0})
    step, currents = 0.01, []
    for k in range(600):
        plant.instance.doStep(k * step, step)
        currents.append(read(plant, "beta.i_a"))
    assert currents[10] == pytest.approx(5.0)
    # q passes 0.9 · 16 A² of 25 A² at ln(25/10.6) = 0.858 s.
    assert currents[84] == pytest.approx(5.0)
    assert currents[90] < 4.99
    assert currents[-1] == pytest.approx(4.0, abs=0.02)


@pytest.mark.parametrize(("gap", "sign"), [(20e-3, 1.0), (26e-3, -1.0)])
def test_sign_of_the_direct_current_that_holds_the_mover(load_fastest: Load, gap: float, sign: float) -> None:
    """Too small a gap needs a current that pushes away, a positive one; too large a gap one that pulls."""
    ends = []
    for i_d in (0.0, sign):
        plant = load_fastest("Plant3DOF")
        plant.initialise({"y.position_start": gap}, 0.0, 10.0)
        command(plant, i_d, 0.0, 0.0)
        put(plant, {f"beta.i_{phase}_cmd": read(plant, f"alpha.i_{phase}") for phase in "abc"})
        delivered(plant, 0.02, 2e-4)
        ends.append(abs(read(plant, "y.position") - gap))
    assert ends[1] < ends[0]


@pytest.mark.parametrize("heat", [0.0, 1.0])
def test_a_continuous_current_whose_square_is_no_number(load_either: Load, heat: float) -> None:
    """1e-200 A squared is 0: the phases get nothing, and the step is none to be refused."""
    plant = load_either("Plant3DOF")
    plant.initialise({"alpha.amplifier.continuous": 1e-200}, 0.0, 1.0)
    put(plant, {"alpha.i_a_cmd": heat})
    assert plant.instance is not None
    plant.instance.doStep(0.0, 1e-3)
    assert read(plant, "alpha.i_a") == pytest.approx(0.0, abs=1e-12)
