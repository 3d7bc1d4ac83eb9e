"""Interpolated law: its table against scipy, poles of the nonlinear law at every gap, an integral that is a current."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linear_model import linearised, vertical_row
from named_controllers import Regulator3DOF, Regulator5DOF
from reference_stage import shape_functions
from scipy.optimize import brentq

from controller_fmu.status import INTERPOLATED, NO_EQUILIBRIUM
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.linear.loop import linearise_loop

DESCRIPTION = PACKAGED_STAGES["3dof"]

MOTORS = ("alpha1", "alpha2", "beta1", "beta2")


def started(gap: float) -> Regulator3DOF:
    """An interpolated regulator at rest at a gap, without limit, that does not answer to speeds."""
    regulator = Regulator3DOF(INTERPOLATED)
    regulator.current_limit, regulator.y.k2 = 0.0, 0.0
    assert regulator.start() == 0
    regulator.y.measured = regulator.y.reference = gap
    assert regulator.step(0.0, 2e-4) == 0
    return regulator


@given(st.floats(18e-3, 32e-3))
def test_table_is_the_equilibrium_and_its_linearisation(gap: float) -> None:
    """Between its points, too: to 1.1 mA, 0.15 % of the gain, 0.05 % of the thrust: an eighth of second differences."""
    regulator = started(gap)
    held = brentq(lambda i: vertical_row(regulator, gap, i), -12.0, 12.0, xtol=1e-14)
    assert regulator.alpha.i_d_cmd == regulator.beta.i_d_cmd == pytest.approx(held, abs=1.1e-3)
    assert regulator.here.gain == pytest.approx(linearised(regulator, gap)[1], rel=1.5e-3)
    assert regulator.here.f1 == pytest.approx(shape_functions(gap)[0], rel=5e-4)


def test_points_themselves_are_exact() -> None:
    assert DESCRIPTION.design.table is not None
    gaps = DESCRIPTION.design.table.gaps
    assert len(gaps) == 15 and gaps[0] <= DESCRIPTION.gap_stop.lower and gaps[-1] >= DESCRIPTION.gap_stop.upper
    for gap in gaps:
        regulator = started(gap)
        held = brentq(lambda i, gap=gap, regulator=regulator: vertical_row(regulator, gap, i), -12.0, 12.0, xtol=1e-14)
        assert regulator.here.current == pytest.approx(held, abs=1e-9)
        assert regulator.here.gain == pytest.approx(linearised(regulator, gap)[1], rel=1e-7)
    beyond = [started(gap).here for gap in (10e-3, 39e-3)]
    assert [each.gain for each in beyond] == [started(gap).here.gain for gap in (gaps[0], gaps[-1])]


@pytest.mark.parametrize("gap", [19.5e-3, 22.2e-3, 25e-3, 28.7e-3])
def test_poles_are_those_of_the_nonlinear_law_at_every_gap(gap: float) -> None:
    """With the controller's constants in the plant; straight lines have another slope than the curve, by 0.5 %."""
    own = {"C3": 327.5, "C4": 8.48, "C5": 0.007, "y.bias": 0.0, "x.bias": 0.0, "z.bias": 0.0, "y.ripple.amplitude": 0.0,
           "attraction_modulation": 0.0}
    ours, theirs = (linearise_loop("Plant3DOF", f"{law}Regulator3DOF", {"y": gap}, plant_parameters=own).closed
                    for law in ("Interpolated", ""))
    assert ours.states == theirs.states
    for rate in theirs.rates:
        assert np.abs(ours.rates - rate).min() < 0.03 * abs(rate), rate


@pytest.mark.parametrize("gap", [18.4e-3, 21e-3, 24.999e-3, 29.3e-3])
def test_the_current_of_the_integral_does_not_change_with_the_gain(gap: float) -> None:
    """In position form it would change by up to a half; and there is no bump between pieces of the table."""
    regulator = started(25e-3)
    regulator.y.model.xi1 = 2e-4
    commands = []
    for k, at in enumerate((25e-3, gap, np.nextafter(gap, 1.0), 25e-3), 1):
        regulator.y.measured = regulator.y.reference = float(at)
        assert regulator.step(2e-4 * k, 2e-4) == 0
        commands.append(regulator.alpha.i_d_cmd - regulator.here.current)
    assert abs(commands[0]) > 1.0
    assert commands == pytest.approx([commands[0]] * 4, rel=1e-12)
    assert regulator.y.model.xi1 == pytest.approx(2e-4, rel=1e-12)


def test_a_level_platform_is_carried_as_the_stage_without_tilts() -> None:
    """Every motor has the direct current of the 3-DOF stage, along a path with errors and an integral."""
    one, other = Regulator3DOF(INTERPOLATED), Regulator5DOF(INTERPOLATED)
    assert one.start() == other.start() == 0
    for k in range(50):
        gap = 25e-3 + 2e-3 * np.sin(0.4 * k) + 1e-4 * k
        one.y.measured = float(gap)
        for motor in MOTORS:
            getattr(other, f"{motor}_place").gap_measured = float(gap)
        one.y.reference = other.y.reference = 24e-3
        assert one.step(2e-4 * k, 2e-4) == other.step(2e-4 * k, 2e-4) == 0
        for motor in MOTORS:
            assert getattr(other, motor).i_d_cmd == pytest.approx(one.alpha.i_d_cmd, abs=1e-9)


def test_constants_without_equilibria_are_refused() -> None:
    for kind in (Regulator3DOF, Regulator5DOF):
        regulator = kind(INTERPOLATED)
        regulator.C3 = 1e5
        assert regulator.start() == NO_EQUILIBRIUM
