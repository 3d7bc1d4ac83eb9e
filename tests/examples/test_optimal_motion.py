"""The planned motions: limits and mechanics of the files, bounds on any motion, their runs, CasADi's optimum."""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from continuous_block import ContinuousBlock
from example_builds import EXAMPLES, script
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import maglev.descriptions.own_fmus
from controller_fmu.feedback_linearisation import demanded_current
from pmlsm.dq_transform import phase_currents
from pmlsm.gap_functions import gap_functions

FOLDER = EXAMPLES / "optimal_motion"
PAGE = Path(__file__).parents[2] / "docs" / "results_controllers.md"
START, TARGET = np.array([25e-3, 0.0, 0.0]), np.array([27e-3, 10e-3, -15e-3])   # m: y, x, z
LIMIT, LEAST_GAP = 4.0, 20e-3
RESISTANCE, VERTEX = 3.5, 2.0 / np.sqrt(3.0)   # of the hexagon of phase limits, of the limit

Motion = np.ndarray


def phases(i_d: float, i_q: float, displacement: float) -> list[float]:
    return list(phase_currents(i_d, i_q, np.pi / 57.15e-3 * (displacement - 57.15e-3 / 2.0)))


@pytest.fixture(scope="module", params=["fastest", "thrifty"])
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def motion(name: str) -> Motion:
    """Rows of a file from the beginning on: time, y, x, z, their rates, i_d and i_q of alpha and beta."""
    rows = np.loadtxt(FOLDER / f"{name}.csv", delimiter=",", skiprows=2)
    rows[:, 0] -= 0.2
    return rows


def energy(rows: Motion) -> float:
    """J, of all phases."""
    return float(1.5 * RESISTANCE * np.sum(np.diff(rows[:, 0]) * np.sum(rows[:-1, 7:] ** 2, axis=1)))


def test_it_holds_to_the_limits_from_rest_to_rest(name: str) -> None:
    rows = motion(name)
    for row, place in ((rows[0], START), (rows[-1], TARGET)):
        np.testing.assert_allclose(row[1:4], place, atol=1e-9)
        np.testing.assert_allclose(row[4:7], 0.0, atol=1e-7)
    assert rows[:, 1].min() >= LEAST_GAP and rows[:, 1].max() <= 30e-3
    largest = [max(map(abs, (*phases(row[7], row[8], place[2]), *phases(row[9], row[10], place[3]))))
               for row, end in pairwise(rows) for place in (row, end)]
    assert max(largest) < LIMIT + 5e-3   # between the points of the collocation a little above
    if name == "fastest":   # as the maximum principle has it: always at a limit
        assert min(largest) > 0.99 * LIMIT


@pytest.fixture(scope="module")
def block() -> ContinuousBlock:
    return ContinuousBlock("Plant3DOF", {f"{axis}.friction.coulomb": 0.0 for axis in "yxz"})


def accelerated(block: ContinuousBlock) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Rates of positions and velocities of the Python block, by these and i_d, i_q."""
    names = [f"{axis}.{what}" for what in ("position", "velocity") for axis in "yxz"]
    names += [f"{motor}.i_{phase}" for motor in ("alpha", "beta") for phase in "abc"]
    rates = [f"{axis}.velocity" for axis in "yxz"] + [f"der({axis}.velocity)" for axis in "yxz"]
    return lambda state, i: block.at(names, [*state, *phases(i[0], i[1], state[1]), *phases(i[2], i[3], state[2])],
                                     rates)


def test_the_block_moves_so_by_these_currents(block: ContinuousBlock, name: str) -> None:
    """Between some of the rows, by scipy; the fastest motion from its beginning to its end, too."""
    rates, rows = accelerated(block), motion(name)

    def after(state: np.ndarray, row: np.ndarray, end: float) -> np.ndarray:
        solved = solve_ivp(lambda _, s: rates(s, row[7:]), (row[0], end), state, method="DOP853", rtol=1e-9,
                           atol=1e-11)
        return np.array(solved.y[:, -1])

    for k in range(0, len(rows) - 1, 5):
        found = after(rows[k, 1:7], rows[k], rows[k + 1, 0])
        np.testing.assert_allclose(found[:3], rows[k + 1, 1:4], rtol=0, atol=1e-9)   # as many digits as the file has
        np.testing.assert_allclose(found[3:], rows[k + 1, 4:7], rtol=0, atol=1e-7)
    if name == "fastest":
        state = rows[0, 1:7]
        for row, end in zip(rows[:-1], rows[1:, 0], strict=True):
            state = after(state, row, end)
        np.testing.assert_allclose(state[:3], TARGET, rtol=0, atol=1e-6)


def thrust(gap: float) -> tuple[float, float]:
    """Accelerations of x and z by 1 A at a gap, m/s²."""
    plant = maglev.descriptions.own_fmus.definition("Plant3DOF").new_block()
    f1 = gap_functions(plant.magnetics.kinds[0].geometry, gap)[0]
    return 2.0 * 0.6135 * f1, 2.0 * 0.8224 * f1


def test_no_motion_is_faster_or_takes_less() -> None:
    """Bounds of a double integrator with the largest thrust that there is, and the constant bias Δ of the stage.

    In time T the acceleration a of a rest-to-rest way d has ∫a = 0 and ∫a² ≥ 12 d²/T³; a viscous guide only adds.
    So ∫(a − Δ)² ≥ 12 d²/T³ + Δ² T, and less by 2 Δ c d/m for what the guide's drag c works against the bias.
    """
    fastest, thrifty = motion("fastest"), motion("thrifty")
    duration = thrifty[-1, 0]
    for k, (distance, mass, strongest) in enumerate(zip(TARGET[1:], (10.6, 8.6), thrust(LEAST_GAP), strict=True)):
        soonest = 2.0 * np.sqrt(abs(distance) / (strongest * VERTEX * LIMIT + 0.05))
        assert fastest[-1, 0] > soonest
        if k == 1:   # z is the way that takes the time
            assert fastest[-1, 0] < 1.25 * soonest
        strongest = thrust(thrifty[:, 1].min())[k]
        current = np.sum(np.diff(thrifty[:, 0]) * thrifty[:-1, 8 + 2 * k] ** 2)
        needed = (12.0 * distance**2 / duration**3 + 0.05**2 * duration - 2.0 * 0.05 * 2.0 / mass * distance)
        least = needed / strongest**2
        assert least < current < 1.25 * least


def polynomial(block: ContinuousBlock, duration: float) -> tuple[float, float]:
    """Energy (J) and largest phase current (A) of a quintic polynomial of time on the straight way, of equal i_d."""
    rates, h = accelerated(block), duration / 200
    total, largest = 0.0, 0.0
    for s in (np.arange(200) + 0.5) / 200:
        way, pace, slope = (10 - 15 * s + 6 * s**2) * s**3, 30 * (s - s**2)**2, 60 * s - 180 * s**2 + 120 * s**3
        state = np.concatenate([START + (TARGET - START) * way, (TARGET - START) * pace / duration])
        wanted = (TARGET - START) * slope / duration**2
        coasting = rates(state, np.zeros(4))[3:]
        q = [-(w - c) / b for w, c, b in zip(wanted[1:], coasting[1:], thrust(state[0]), strict=True)]
        with_q = rates(state, np.array([0.0, q[0], 0.0, q[1]]))[3]
        _, _, f3, f4 = gap_functions(block.block.magnetics.kinds[0].geometry, state[0])
        i_d, feasible = demanded_current(wanted[0] - with_q, 9.81, 0.0, 4 * 8.71, 4 * 0.0045, 0.0, f3, f4)
        assert feasible
        total += 1.5 * RESISTANCE * h * (2.0 * i_d**2 + q[0] ** 2 + q[1] ** 2)
        largest = max(largest, *map(abs, (*phases(i_d, q[0], state[1]), *phases(i_d, q[1], state[2]))))
    return total, largest


def said() -> dict[str, list[float]]:
    """Numbers in the rows of the tables of the best motion, by the first cell."""
    _, _, section = PAGE.read_text(encoding="utf-8").partition("\n## Optimal motion\n")
    lines = [line.strip("| \n").split(" | ") for line in section.splitlines() if line.startswith("| ")]
    return {cells[0]: [float(number) for cell in cells[1:] for number in cell.split(", ")]
            for cells in lines if len(cells) > 1 and cells[1][0].isdigit()}


@pytest.mark.usefixtures("slow")
def test_the_page_states_the_gain_of_the_optimum(block: ContinuousBlock) -> None:
    duration = brentq(lambda span: polynomial(block, span)[1] - LIMIT, 0.15, 0.6, rtol=1e-4)
    found = said()
    assert found["duration within 4 A (s)"] == pytest.approx([motion("fastest")[-1, 0], duration], abs=6e-4)
    assert found["energy in 0.6 s (J)"] == pytest.approx([energy(motion("thrifty")), polynomial(block, 0.6)[0]],
                                                         abs=6e-3)


def test_the_page_says_how_they_run(fastest_fmus: Path) -> None:
    example: Any = script(FOLDER / "run.py")
    runs = {name: maglev.run(FOLDER / f"{name}.toml", fmus=fastest_fmus) for name in example.COLOURS}
    found = said()
    for row in example.motion_table(runs).splitlines()[1:]:
        name, numbers = row[:34].strip(), [float(number.strip(",")) for number in row[34:].split()]
        assert found[name] == pytest.approx(numbers, abs=0.05 if "time" in name else 0.3), name
    assert not any(run.metrics.failed for run in runs.values())


def test_casadi_finds_the_optimum_and_the_derivatives(native_fmus: Path, tmp_path: Path) -> None:
    pytest.importorskip("casadi", reason="the extra `optimal` is not installed")
    plan: Any = script(FOLDER / "plan.py")
    fmpy.extract(str(native_fmus / "Plant3DOF.fmu"), str(tmp_path))
    stage = plan.Stage(tmp_path)
    point = [np.array([24e-3, 3e-3, -2e-3]), np.array([0.1, -0.2, 0.1]), np.array([0.5, 2.0, -1.0, 1.5])]
    slopes = [np.array(each) for each in stage.at.jacobian()(*point, *stage.at(*point))[:3]]
    for k, of in enumerate(slopes):
        for n in range(len(point[k])):
            step = np.zeros(len(point[k]))
            step[n] = 1e-6
            moved = [np.array(stage.at(*(each + sign * step if j == k else each for j, each in enumerate(point)))[0])
                     for sign in (1, -1)]
            np.testing.assert_allclose(of[:, n], ((moved[0] - moved[1]) / 2e-6).ravel(), rtol=1e-5, atol=1e-6)
    assert plan.planned(stage, intervals=16).duration == pytest.approx(motion("fastest")[-1, 0], rel=0.02)
    assert plan.planned(stage, 0.6, intervals=40).energy == pytest.approx(energy(motion("thrifty")), rel=0.03)
