"""The worked examples: their designs, the numbers in docs/results_controllers.md, and their currents at the limit."""

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from example_builds import EXAMPLES

import maglev

SCENARIOS = Path(__file__).parents[2] / "scenarios"
PAGE = Path(__file__).parents[2] / "docs" / "results_controllers.md"

NAMES = ("lqi_kalman", "h_infinity", "mpc_osqp", "disturbance_observer")
REGULATOR = "the thesis's regulator"
LIMITED = ("alpha.i_d", "alpha.i_q", "beta.i_q")

FIRST_STEP = """
extends = "{scenarios}/3dof/3dof-setpoints-improved.toml"
name = "first-step"
title = "The first step of the setpoints"
stop_time = "5.9 s"
"""

LARGE_STEP = """
extends = ["{scenarios}/loops/3dof.toml", "{scenarios}/gains/3dof-improved.toml"]
name = "large-step"
title = "A step of 40 mm"
stop_time = "4.5 s"
[fmus.plant.start]
"y.position_start" = "25 mm"
[[signals]]
to = "controller.y.reference"
kind = "constant"
value = "25 mm"
[[signals]]
to = "controller.x.reference"
kind = "steps"
unit = "mm"
times = [0, 0.2]
values = [0, 40]
[[signals]]
to = "controller.z.reference"
kind = "steps"
unit = "mm"
times = [0, 0.2]
values = [0, -40]
"""


@pytest.fixture(autouse=True)
def beside(monkeypatch: pytest.MonkeyPatch) -> None:
    """Import from the folder of the examples, as they do themselves."""
    monkeypatch.syspath_prepend(EXAMPLES)


def simulated(controller: str | type, text: str, fmus: Path, folder: Path) -> maglev.Run:
    """A scenario under an example, by its name or as its class, or under the thesis's regulator."""
    scenario = folder / "scenario.toml"
    scenario.write_text(text.format(scenarios=SCENARIOS.as_posix()))
    given: Path | type | None = None
    if controller != REGULATOR:
        given = EXAMPLES / f"{controller}.py" if isinstance(controller, str) else controller
    return maglev.run(scenario, controller=given, fmus=fmus)


def said(table: str) -> dict[str, list[list[float]]]:
    """Numbers of a table of the page: by controller, those of the axes in each column."""
    text = PAGE.read_text(encoding="utf-8").split(f"<!-- {table} -->")[1].split(f"<!-- end of {table} -->")[0]
    rows = [line.strip("| \n").split(" | ") for line in text.strip().splitlines()[2:]]
    return {name.strip("`"): [[float(number) for number in cell.split(", ")] for cell in cells]
            for name, *cells in rows}


def responds(run: maglev.Run, settling: list[float], overshoot: list[float]) -> None:
    """Settling to 10 µm (s) and overshoot (%) are as they are said; a start 0.3 µm off moves them by 0.02 and 0.1."""
    assert [step.settling_time[10e-6] for step in run.metrics.steps] == pytest.approx(settling, abs=0.05)
    assert [1e2 * step.overshoot for step in run.metrics.steps] == pytest.approx(overshoot, abs=0.3)


# What the page says of the others is run in the thorough tests: their programs take seconds.
SOME = [REGULATOR, "lqi_kalman", *(pytest.param(name, marks=pytest.mark.thorough) for name in NAMES[1:])]


@pytest.mark.few(1)
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.filterwarnings("ignore:controller .* has no")
def test_it_runs(name: str, fastest_fmus: Path, tmp_path: Path) -> None:
    """Its program runs with what is installed, and lets nothing fall while the currents come."""
    run = simulated(name, FIRST_STEP.replace("5.9 s", "0.3 s"), fastest_fmus, tmp_path)
    assert len(run.time) == 301
    for axis in "yxz":
        assert np.abs(run[f"plant.{axis}.position"] - run[f"controller.{axis}.reference"]).max() < 0.5e-3
        assert np.ptp(run[f"plant.{axis}.position"]) > 0.0


@pytest.mark.thorough
@pytest.mark.parametrize("name", SOME)
@pytest.mark.filterwarnings("ignore:controller .* has no")
def test_the_first_step_is_as_the_page_says(name: str, fastest_fmus: Path, tmp_path: Path) -> None:
    run = simulated(name, FIRST_STEP, fastest_fmus, tmp_path)
    rms, settling, overshoot = said("first step")[name]
    assert [step.axis for step in run.metrics.steps] == ["y", "x", "z"]
    measured = [1e3 * row.value for row in run.measures if row.quantity == "rms error"]
    assert measured == pytest.approx(rms, rel=0.01)
    responds(run, settling, overshoot)
    assert not run.metrics.failed
    for current in LIMITED:
        assert np.abs(run[f"controller.{current}_cmd"]).max() <= 4.0


@pytest.mark.thorough
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.filterwarnings("ignore:controller .* has no")
def test_a_step_of_40_mm_takes_all_the_current_and_settles(name: str, fastest_fmus: Path, tmp_path: Path) -> None:
    run = simulated(name, LARGE_STEP, fastest_fmus, tmp_path)
    used = 3.6 if name == "mpc_osqp" else 4.0   # its programme leaves a tenth
    for current in ("alpha.i_q", "beta.i_q"):
        command = np.abs(run[f"controller.{current}_cmd"])
        assert command.max() <= 4.0
        assert (command > used - 1e-3).sum() > 30   # ms
    assert [step.axis for step in run.metrics.steps] == ["x", "z"]
    responds(run, *said("large step")[name])
    assert not run.metrics.failed
    assert not run["plant.at_stop"].any()
    assert max(run.metrics.end_errors.values()) < 10e-6
    assert np.abs(run["plant.y.position"] - 25e-3).max() < 1e-3


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore:controller .* has no")
def test_lqi_recovers_where_its_references_ask_for_more_than_the_limit(
        fastest_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The smoothed references spare it the limit; faster ones, with an integral that did not wait, lose the mover."""
    lqi = import_module("lqi_kalman")
    monkeypatch.setattr(lqi, "PACE", np.array([22.0, 15.0, 15.0]))
    run = simulated(lqi.LQI, LARGE_STEP, fastest_fmus, tmp_path)
    assert (np.abs(run["controller.alpha.i_q_cmd"]) == 4.0).sum() > 300   # ms
    assert not run.metrics.failed
    assert max(step.settling_time[10e-6] for step in run.metrics.steps) < 1.0
    assert max(step.overshoot for step in run.metrics.steps) < 0.2


@pytest.mark.filterwarnings("ignore:controller .* has no")
def test_the_thesis_regulator_drops_the_mover_there(fastest_fmus: Path, tmp_path: Path) -> None:
    """The page says so, and that (5.7) is why: its direct current makes up for quadrature currents that do not flow."""
    run = simulated(REGULATOR, LARGE_STEP, fastest_fmus, tmp_path)
    assert run.metrics.failed
    assert run["plant.at_stop"].any()


def test_lqi_and_its_filter_are_stable_at_every_gap() -> None:
    lqi = import_module("lqi_kalman")
    for gap in lqi.GAPS:
        design = lqi.Design(gap)
        n = 10
        A, B, C = design.A[:n, :n], design.B[:n], design.C[:, :n]
        closed = np.block([[A - B @ design.feedback[:, :n], -B @ design.feedback[:, n:]],
                           [lqi.SAMPLE_TIME * C, np.eye(3)]])
        error = design.A @ (np.eye(n + 3) - design.filter @ design.C)
        assert np.abs(np.linalg.eigvals(A)).max() > 1.0
        assert np.abs(np.linalg.eigvals(closed)).max() < 1.0
        assert np.abs(np.linalg.eigvals(error)).max() < 1.0


@pytest.mark.usefixtures("slow")
def test_h_infinity_reaches_the_norm_that_it_is_designed_for() -> None:
    """‖[I; K] (I − G K)⁻¹ [I, G]‖∞ of the shaped plant, by its frequency response, lies between the least γ and γ."""
    import control  # which takes a second

    design = import_module("h_infinity")
    for crossover, a in ((50.0, 15.0), (35.0, 12.0)):
        law = design.LoopShaping(crossover, a)
        plant = control.ss(law.A, law.B, law.C, 0.0)
        controller = control.ss(law.A + law.B @ law.F + law.H @ law.C, -law.H, law.F, 0.0)
        frequencies = np.logspace(-2, 4, 4000)
        G, K = (system(1j * frequencies) for system in (plant, controller))
        # Singular values of a product of a column and a row are the product of their lengths.
        norm = np.sqrt(1 + abs(K)**2) * np.sqrt(1 + abs(G)**2) / abs(1 - G * K)
        assert law.gamma / design.SUBOPTIMAL < norm.max() <= law.gamma * (1 + 1e-6)
        assert law.gamma < 4.0


@pytest.mark.usefixtures("slow")
def test_without_limits_the_programme_is_the_linear_quadratic_regulator() -> None:
    import control  # which takes a second

    mpc = import_module("mpc_osqp")
    for acceleration in mpc.ACCELERATION.values():
        P, F = mpc.prediction(acceleration)
        A = [[1.0, mpc.STEP], [0.0, 1.0]]
        B = [[mpc.STEP**2 / 2.0], [mpc.STEP]]
        Q = np.diag([acceleration**2 / mpc.ERROR**2, acceleration**2 / mpc.VELOCITY**2])
        gain, _, _ = control.dlqr(A, B, Q, [[1.0]])
        np.testing.assert_allclose(np.linalg.solve(P, F)[:1], gain, rtol=1e-8)


def test_the_observer_finds_a_constant_disturbance() -> None:
    """An axis pushed by 0.3 m/s² next to a command of −0.1 m/s²: p = ½ 0.2 t²."""
    observing = import_module("disturbance_observer")
    observer = observing.DisturbanceObserver(60.0)
    observer.start(0.0)
    for k in range(4000):
        t = k * observing.SAMPLE_TIME
        observer.update(0.5 * 0.2 * t**2, -0.1)
    t += observing.SAMPLE_TIME
    np.testing.assert_allclose(observer.state, [0.5 * 0.2 * t**2, 0.2 * t, 0.3], rtol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_scripts_are_short_and_their_pictures_small(name: str) -> None:
    assert len((EXAMPLES / f"{name}.py").read_text(encoding="utf-8").splitlines()) <= 150
    assert (PAGE.parent / f"{name}.png").stat().st_size <= 150e3
