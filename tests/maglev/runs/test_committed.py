"""The committed baselines notice what changes a co-simulation: bit for bit, and at their committed tolerances."""

from pathlib import Path

import pytest
from packaged_plans import RUNS

from maglev.runs.baseline_check import check_run
from maglev.runs.baseline_file import DIGESTS, baseline_file, read_digests
from maglev.runs.check_outcome import CheckResult, describe
from maglev.runs.preparation import prepare
from maglev.scenario.layers import PACKAGED
from maglev.scenario.run_plan import RunPlan
from maglev.scenario.settings import start_values

BASELINES = PACKAGED / "baselines"
SMOOTH = [run for run in RUNS if "smooth" in run.name]
every_pair = pytest.mark.parametrize("run", SMOOTH, ids=lambda run: run.name)


def checked(run: RunPlan, fmus: Path, *settings: str) -> CheckResult:
    return check_run(BASELINES, prepare(run, fmus, {}, start_values(settings)), {})


def deviates(result: CheckResult, latest: float) -> None:
    """The check names a signal and a time before the latest (s)."""
    assert result.status == "deviated", describe(result)
    assert result.deviation is not None
    assert result.deviation.signal in result.message
    assert f"t = {result.deviation.time:.9g} s" in result.message
    assert result.deviation.time <= latest


def test_every_run_has_a_baseline_and_every_baseline_a_run() -> None:
    expected = {BASELINES / DIGESTS, *(baseline_file(BASELINES, run.name) for run in RUNS)}
    assert set(BASELINES.iterdir()) == expected
    assert set(read_digests(BASELINES)) == {run.name for run in RUNS}
    assert all(file.stat().st_size < 1_000_000 for file in expected)


@pytest.mark.few(1)
@every_pair
def test_an_unchanged_pair_passes(fmus: Path, run: RunPlan) -> None:
    result = checked(run, fmus)
    assert result.status == "passed", describe(result)


@every_pair
def test_a_plant_constant_that_is_off_by_a_thousandth(fastest_fmus: Path, run: RunPlan) -> None:
    constants = {"2dof": {"C1": 14.2, "C2": 791.0, "C3": 30.9, "C4": 0.12},
                 "3dof": {"C1": 0.6135, "C2": 0.8224, "C3": 334.52, "C4": 8.71, "C5": 0.0045}}[run.name[:4]]
    for name, value in constants.items():
        deviates(checked(run, fastest_fmus, f"plant.{name}={1.001 * value!r}"), latest=0.7)


@every_pair
def test_a_controller_that_samples_one_step_late(fastest_fmus: Path, run: RunPlan) -> None:
    """The plant moves first, so that the currents of a sample flow a step later."""
    late = run.model_copy(update={"fmus": dict(reversed(run.fmus.items()))})
    deviates(checked(late, fastest_fmus), latest=0.6)


@every_pair
def test_a_motor_with_two_phases_swapped(fastest_fmus: Path, run: RunPlan) -> None:
    swap = {"i_a_cmd": "i_b_cmd", "i_b_cmd": "i_a_cmd"}
    connections = []
    for source, target in run.connections:
        motor, _, phase = source.rpartition(".")
        first_motor = motor in ("controller.motor", "controller.alpha")
        connections.append((f"{motor}.{swap.get(phase, phase)}" if first_motor else source, target))
    assert connections != run.connections
    deviates(checked(run.model_copy(update={"connections": connections}), fastest_fmus), latest=0.1)


# A millionth of a threshold acts only where something comes that close to it; one of the field's highest terms is less
# than the last bit of the field.
HARDLY_ACTING = ("trip", ".stop.lower", ".stop.upper", "field.lower", "field.upper", "encoder.resolution",
                 "field.B10", "field.B11", "field.B12")


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["2dof-effects-motors", "3dof-laws-nonlinear"])
def test_a_millionth_of_a_parameter_that_acts_is_noticed(fastest_fmus: Path, name: str) -> None:
    """Where it is not, a hundredth is not noticed either."""
    run = next(run for run in RUNS if run.name == name)
    values = prepare(run, fastest_fmus, {}, {}).parameters()

    def noticed(parameter: str, by: float) -> bool:
        return checked(run, fastest_fmus, f"{parameter}={values[parameter] * by!r}").status != "passed"

    tried = [parameter for parameter, value in values.items()
             if value != 0.0 and not any(word in parameter for word in HARDLY_ACTING)]
    unnoticed = [parameter for parameter in tried if not noticed(parameter, 1.0 - 1e-6)]
    assert len(tried) - len(unnoticed) > 30
    assert [parameter for parameter in unnoticed if noticed(parameter, 0.99)] == []
