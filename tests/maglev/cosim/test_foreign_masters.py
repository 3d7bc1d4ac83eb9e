"""Plant and controller under masters that are not ours: the same numbers, bit for bit, once the order is the same.

docs/using_fmus.md has the measured differences, docs/importers.md the versions.
"""

from pathlib import Path

import numpy as np
import pytest
from interop.loops import foreign, loop, ours, ours_from_zero, ours_in_nanoseconds, with_start
from native_builds import built_once

from maglev.descriptions.own_fmus import SYSTEMS
from maglev.scenario.catalogue import PYTHON, build_systems
from maglev.scenario.loading import load_plan
from maglev.scenario.scenario_system import build_scenario

STOP_TIME = 1.5   # s, with a step of the references at 1 s
SMOOTH = {"plant.encoder.resolution": 0.0}
JACOBI_ROUNDING = 1e-12   # m


@pytest.fixture(scope="session")
def systems(native_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the systems of native FMUs."""
    return built_once(tmp_path_factory, "systems", lambda folder: build_systems(SYSTEMS, native_fmus, folder))


def assert_moves(rows: np.ndarray) -> None:
    assert np.ptp(rows, axis=0).min() > 1e-6, "something has to move for this to mean anything"


@pytest.mark.few(1)
def test_ecos_is_our_jacobi_order(either_kind: Path, tmp_path: Path) -> None:
    plan = loop("Stage3DOF", STOP_TIME)
    rows = foreign("ecos", plan, either_kind, tmp_path)
    assert_moves(rows)
    assert np.array_equal(rows, ours(plan, either_kind, "jacobi"))


@pytest.mark.few(1)
def test_libcosim_is_our_jacobi_order_with_its_clock(either_kind: Path, tmp_path: Path) -> None:
    plan = loop("Stage3DOF", STOP_TIME)
    rows = foreign("libcosim", plan, either_kind, tmp_path)
    assert_moves(rows)
    assert np.array_equal(rows, ours_in_nanoseconds(plan, either_kind))


def test_libcosim_without_encoder_steps_is_our_jacobi_order(native_fmus: Path, tmp_path: Path) -> None:
    """Its steps differ from ours in the last digit, and no encoder makes a count of that."""
    plan = with_start(loop("Stage3DOF", STOP_TIME), SMOOTH)
    rows = foreign("libcosim", plan, native_fmus, tmp_path, start=SMOOTH)
    assert_moves(rows)
    assert np.abs(rows - ours(plan, native_fmus, "jacobi")).max() <= JACOBI_ROUNDING


@pytest.mark.few(2)
@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("tool", ["ecos", "libcosim"])
def test_system_without_ports(native_fmus: Path, systems: Path, tmp_path: Path, tool: str, system: str) -> None:
    plan = loop(system, STOP_TIME)
    rows = foreign(tool, plan, native_fmus, tmp_path, systems / f"{system}NoPorts.ssp")
    assert_moves(rows)
    same = ours(plan, native_fmus, "jacobi") if tool == "ecos" else ours_in_nanoseconds(plan, native_fmus)
    assert np.array_equal(rows, same)


@pytest.mark.few(1)
@pytest.mark.parametrize("system", ["Stage2DOF", "Stage3DOF"])
def test_fmpy_ssp_is_our_jacobi_order_from_zero(native_fmus: Path, systems: Path, tmp_path: Path, system: str) -> None:
    """fmpy exchanges nothing before the first step: the controller waits for a measurement."""
    plan = loop(system, STOP_TIME)
    rows = foreign("fmpy.ssp", plan, native_fmus, tmp_path, systems / f"{system}.ssp")
    assert_moves(rows)
    assert np.array_equal(rows, ours_from_zero(plan, native_fmus))


@pytest.mark.thorough
def test_fmpy_ssp_with_fmus_in_python(fmus: Path, tmp_path: Path) -> None:
    plan = loop("Stage3DOF", STOP_TIME)
    build_systems(["Stage3DOF"], fmus, tmp_path)
    rows = foreign("fmpy.ssp", plan, fmus, tmp_path, tmp_path / "Stage3DOF.ssp")
    assert_moves(rows)
    assert np.array_equal(rows, ours_from_zero(plan, fmus))


@pytest.mark.few(1)
@pytest.mark.parametrize("coupling", ["adaptive", "loose"])
def test_fmpy_ssp_adapts_as_we_do(fmus: Path, tmp_path: Path, coupling: str) -> None:
    """Two sinusoids under the regulator that adapts, and with constants from an estimator: the same bits."""
    plan = load_plan(f"3dof-thrust-loss-{coupling}")
    plan = plan.model_copy(update={"stop_time": 0.1, "signals": tuple(
        signal for signal in plan.signals if signal.to.startswith("controller."))})
    system, _ = build_scenario(plan, tmp_path, PYTHON)
    rows = foreign("fmpy.ssp", plan, fmus, tmp_path, system)
    assert_moves(rows)
    assert np.array_equal(rows, ours_from_zero(plan, fmus, system))
