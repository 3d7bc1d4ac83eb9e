"""The scenarios that come with the package: each starts at rest, and together they cover the thesis's figures."""

import pytest

from scenarios.loading import PACKAGED, load_runs, load_scenario, packaged_runs, packaged_scenarios
from scenarios.scenario import Scenario

RUNS = [run for name in packaged_scenarios() for run in load_runs(name)]
CONTROL_FIGURES = {f"4.{k}" for k in range(18, 32)} | {f"5.{k}" for k in range(20, 40)}


@pytest.mark.parametrize("run", RUNS, ids=lambda run: run.name)
def test_runs_start_at_rest_at_their_references(run: Scenario) -> None:
    assert list(run.fmus) == ["controller", "plant"], "the controller samples before the plant moves"
    signals = {signal.to: signal for signal in run.signals}
    for axis, names in run.axes.items():
        start = run.fmus["plant"].start[f"{axis}.position_start"].value
        assert start == signals[names.reference].value(0.0)


def test_names_are_those_of_the_files_and_variants() -> None:
    assert packaged_runs() == {run.name: run.path.stem for run in RUNS}
    for run in RUNS:
        assert run.name.startswith(run.path.stem)
        assert run.path == PACKAGED / f"{run.path.stem}.toml"
        assert load_scenario(run.name).title == run.title
    assert len({run.title for run in RUNS}) == len(RUNS)


def test_every_figure_of_the_control_experiments_has_a_run() -> None:
    figures = {figure for run in RUNS for figure in run.figures}
    assert figures == CONTROL_FIGURES


def test_every_scenario_has_claims_or_is_for_comparison_only() -> None:
    claimed = {run.path.stem for run in RUNS if run.claims}
    assert {run.path.stem for run in RUNS} - claimed == {"2dof-smooth", "3dof-smooth"}


def test_claims_name_a_place_in_the_thesis() -> None:
    for run in RUNS:
        for claim in run.claims:
            assert claim.source.startswith("p. "), claim
            assert claim.not_testable is None or claim.reason is None


def test_comparisons_name_what_the_other_run_has() -> None:
    for run in RUNS:
        for claim in run.claims:
            if claim.than is not None:
                other = load_scenario(claim.than)
                axes = [claim.than_axis] if claim.than_axis else claim.axes or run.axes
                assert set(axes) <= set(other.axes), claim
                assert set(other.metrics.bands) >= ({claim.band} if claim.band else set())


def test_every_law_has_a_smooth_run_that_is_checked_to_the_nanometre() -> None:
    smooth = [run for run in RUNS if "smooth" in run.name]
    assert {run.fmus["controller"].model for run in smooth} == {
        "Regulator2DOF", "LinearRegulator2DOF", "PID2DOF",
        "Regulator3DOF", "LinearRegulator3DOF", "ScheduledRegulator3DOF", "PID3DOF"}
    for run in smooth:
        assert run.fmus["plant"].start["encoder.resolution"].value == 0
        for axis in run.axes.values():
            assert run.check.signals[axis.position].absolute <= 1e-9
            assert run.check.signals[axis.position].relative == 0.0
