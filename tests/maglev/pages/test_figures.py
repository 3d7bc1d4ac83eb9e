import numpy as np
import pytest
from described_stages import written
from facts import require_facts
from pydantic import ValidationError
from report_runs import all_recorded, failed, of_procedure, packaged, recorded, renamed, with_columns, without_anything

from maglev.pages.figures import MOVING, Figure, Panel, own_outputs, read_figures, shown_figures
from maglev.pages.plot_data import run_signals
from maglev.scenario.layers import packaged_runs
from maglev.scenario.loading import load_plans
from maglev.user.adoption import know_stage

FIGURES = read_figures()


def test_every_figure_with_a_run_is_described():
    numbers = {figure.number for figure in FIGURES}
    # What lies between is drawn by the procedures, or shows no run.
    assert numbers == {"4.15", "4.16", *(f"4.{k}" for k in range(18, 32)), *(f"5.{k}" for k in range(16, 19)),
                       *(f"5.{k}" for k in range(20, 40))}


def test_every_run_named_exists():
    assert {run for figure in FIGURES for run in figure.runs} <= set(packaged_runs())
    assert set(MOVING) <= set(packaged_runs())


@pytest.mark.parametrize("name", packaged_runs())
@pytest.mark.usefixtures("slow")
def test_a_scenario_is_in_the_figures_that_it_names(name):
    (plan,) = load_plans(name)
    assert set(plan.figures) <= {figure.number for figure in FIGURES if name in figure.runs}


@pytest.mark.usefixtures("slow")
def test_every_figure_is_shown_with_all_its_runs_and_panels():
    results = all_recorded()
    shown = shown_figures(FIGURES, results)
    assert [each.figure for each in shown[:len(FIGURES)]] == FIGURES
    for each in shown:
        assert [run.plan.name for run in each.recorded] == list(each.figure.runs)
        kinds = [text.split()[0] for text in each.figure.panels]
        if each.number is not None:
            assert list(dict.fromkeys(panel.kind for panel in each.panels)) == list(dict.fromkeys(kinds))
    assert len({each.id for each in shown}) == len(shown)
    assert {run for each in shown for run in each.figure.runs} == {run.plan.name for run in results}


def test_a_star_means_every_axis_or_motor():
    (shown,) = shown_figures([Figure(caption="", runs={"3dof-setpoints": "a"}, panels=["error *", "currents *"])],
                             [recorded(packaged("3dof-setpoints"))])
    assert shown.panels == [Panel("error", "y"), Panel("error", "x"), Panel("error", "z"),
                            Panel("currents", "alpha"), Panel("currents", "beta")]


def test_a_panel_without_data_is_left_out():
    result = recorded(packaged("2dof-setpoints"))
    result = with_columns(result, {name: column for name, column in result.columns.items()
                                   if name != "plant.v.velocity"})
    (shown,) = [each for each in shown_figures(FIGURES, [result]) if each.id == "figure-4-18"]
    assert shown.panels == [Panel("position", "v"), Panel("error", "v")]


def test_outputs_of_a_users_own_have_panels_of_their_own():
    """After those of the figure, with their samples within a ten thousandth."""
    result = recorded(packaged("2dof-setpoints"))
    own = 3e4 * result.time ** 2
    result = with_columns(result, {**result.columns, "controller.estimate": own, "controller.flag": own > 1.0})
    shown = shown_figures(FIGURES, [result])
    assert {each.panels[-1] for each in shown} == {Panel("own", "controller.estimate")}
    assert {panel.kind for panel in shown[0].panels[:-1]}.isdisjoint({"own"})
    signal = run_signals(result, shown, 16000, ("own",))["signals"]["controller.estimate"]
    assert signal["tolerance"] == pytest.approx(1e-4 * own.max())


def test_outputs_of_a_users_stage_are_those_of_a_stage(tmp_path):
    """Of motors and axes that ours have not; what its controller puts out next to stays the user's own."""
    know_stage(written(tmp_path / "pair.toml", "side-by-side", {"# poles =": "poles =",
                                                                "# observer_time": "observer_time"}))
    (plan,) = load_plans(str(tmp_path / "pair-setpoints.toml"))
    columns = ("plant.left.gap", "plant.right.winding.rise", "controller.left.i_d_cmd", "controller.estimate")
    assert own_outputs(plan, dict.fromkeys(columns, np.zeros(2))) == ["controller.estimate"]


def test_a_run_of_no_figure_gets_one_of_its_own():
    shown = shown_figures(FIGURES, [recorded(renamed("2dof-setpoints", "mine"))])
    assert [each.title for each in shown] == ["Run mine"]
    assert {panel.kind for panel in shown[0].panels} == {"position", "speed", "error", "commands", "currents"}


def test_a_run_of_a_procedure_gets_none_but_stays_in_those_of_the_thesis():
    assert shown_figures(FIGURES, [recorded(of_procedure("2dof-setpoints", "parabola"))]) == []
    assert shown_figures(FIGURES, [recorded(of_procedure("2dof-setpoints", "2dof-setpoints"))]) != []


def test_a_run_without_axes_has_its_currents():
    (shown,) = shown_figures(FIGURES, [recorded(renamed("2dof-setpoints", "mine").model_copy(update={"axes": {}}))])
    assert {panel.kind for panel in shown.panels} == {"commands", "currents"}
    assert shown_figures(FIGURES, [recorded(without_anything("mine"))]) == []


def test_a_failed_run_stays_with_a_figure_that_shows_another():
    results = [recorded(packaged("2dof-step-4-nonlinear")), failed(packaged("2dof-step-4-linear"), "why")]
    (shown,) = shown_figures(FIGURES, results)
    assert shown.runs == results
    assert shown.recorded == results[:1]
    assert shown_figures(FIGURES, results[1:]) == []


@pytest.mark.parametrize("panel", ["positions y", "position", "y"])
def test_an_unknown_panel_is_refused(panel):
    with pytest.raises(ValidationError) as refusal:
        Figure(caption="", runs={"a": "a"}, panels=[panel])
    require_facts(refusal.value.errors()[0], f"'{panel}'", "position, speed, error, commands, currents")
