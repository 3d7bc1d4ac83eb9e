"""The scenarios that come with the package: each starts at rest, and together they cover the thesis's figures."""

import re
from pathlib import Path

import pytest
from packaged_plans import RUNS

from maglev.descriptions.own_fmus import definition
from maglev.identification.regressors import ESTIMATED_STAGES
from maglev.scenario.layers import PACKAGED, packaged_runs
from maglev.scenario.loading import load_plan
from maglev.scenario.procedure import ProcedureSettings
from maglev.scenario.run_plan import RunOutput, RunPlan
from studies.estimation import read_settings

PROCEDURES: dict[str, ProcedureSettings] = {run.procedure.name: run.procedure for run in RUNS if run.procedure}
IN_PROCEDURES = {run.name for run in RUNS if run.procedure}

# The identified models next to the stages, and the control experiments; the charts of what was identified before.
RUN_FIGURES = {f"4.{k}" for k in (15, 16, *range(18, 32))} | {f"5.{k}" for k in (16, 17, 18, *range(20, 40))}
CHARTS = [f"4.{k}" for k in range(8, 15)] + [f"5.{k}" for k in range(7, 16)]

every_procedure = pytest.mark.parametrize("procedure", PROCEDURES.values(), ids=lambda procedure: procedure.name)


def file_of(run: RunPlan) -> Path:
    assert isinstance(run.source, Path)
    return run.source


def start_of(run: RunPlan, name: str) -> float:
    """Start value of `fmu.variable`: the scenario's, or the FMU's."""
    fmu, _, variable = name.partition(".")
    entry = run.fmus[fmu]
    if variable in entry.start:
        return float(entry.start[variable].value)
    described = definition(str(entry.model))
    return float(described.start_value(next(v for v in described.variables if v.name == variable)))


@pytest.mark.parametrize("run", RUNS, ids=lambda run: run.name)
def test_runs_start_at_rest_at_their_references(run: RunPlan) -> None:
    loop = [name for name in run.fmus if name != "measurement"]
    assert loop[:2] == ["controller", "plant"], "the controller samples before the plant moves"
    assert "measurement" not in list(run.fmus)[1:], "and gets what is measured at the same instant"
    signals = {signal.to: signal for signal in run.signals}
    for axis, names in run.axes.items():
        if names.reference.startswith("plant."):
            continue   # a tilt that nobody commands, and that leans on its guides
        signal = signals.get(names.reference)
        reference = start_of(run, names.reference) if signal is None else signal.value(0.0)
        assert start_of(run, f"plant.{axis}.position_start") == reference


@pytest.mark.parametrize("run", RUNS, ids=lambda run: run.name)
def test_estimators_stand_beside_the_loop_where_something_is_identified(run: RunPlan) -> None:
    if run.name.endswith("-loose"):
        return   # what is estimated there is fed back
    others = {name: fmu for name, fmu in run.fmus.items() if name not in ("measurement", "controller", "plant")}
    assert {fmu.model for fmu in others.values()} <= {"Estimator2DOF" if run.name[:4] == "2dof" else "Estimator3DOF"}
    # Equilibrium currents are measured, and the identified model only runs.
    simulated = run.name.endswith(("equilibrium-currents", "identification-model"))
    assert bool(others) == ((run.name in IN_PROCEDURES and not simulated) or file_of(run).stem.endswith("-estimator"))
    for name, fmu in others.items():
        assert all(source.startswith("plant.") for source in fmu.inputs.values()), "they see what a stage has"
        assert not any(source.startswith(f"{name}.") for source, _ in run.wires.values())


@pytest.mark.usefixtures("slow")
def test_names_are_those_of_the_files_and_variants() -> None:
    assert packaged_runs() == {run.name: file_of(run).stem for run in RUNS}
    for run in RUNS:
        assert run.name.startswith(file_of(run).stem)
        assert run.source == PACKAGED / run.name[:4] / f"{file_of(run).stem}.toml"
        assert load_plan(run.name).title == run.title
    assert len({run.title for run in RUNS}) == len(RUNS)


def test_every_figure_has_a_run_or_is_one_chart_of_a_procedure() -> None:
    assert {figure for run in RUNS for figure in run.figures} == RUN_FIGURES
    charts = [number for procedure in PROCEDURES.values() for number in procedure.figures.values()]
    assert sorted(charts) == sorted(CHARTS)


def test_every_scenario_has_claims_or_is_for_comparison_only() -> None:
    claimed = {file_of(run).stem for run in RUNS if run.claims or (run.procedure and run.procedure.claims)}
    # The thesis leaves constants that change, and tilts, to future work, and has no payloads.
    assert {file_of(run).stem for run in RUNS} - claimed == {"2dof-smooth", "3dof-smooth", "2dof-forgetting",
                                                         "2dof-push",
                                                         "3dof-push", "2dof-measurement", "3dof-measurement",
                                                         "2dof-faults", "3dof-faults",
                                                         "3dof-payload", "2dof-effects", "3dof-effects",
                                                         "2dof-laws", "3dof-laws", "2dof-estimator",
                                                         "2dof-thrust-loss", "3dof-thrust-loss", "3dof-magnet-loss",
                                                         "3dof-estimator",
                                                         *(p.stem for p in (PACKAGED / "5dof").glob("*.toml"))}


def test_claims_name_a_place_in_the_thesis() -> None:
    for run in RUNS:
        for claim in run.claims:
            assert claim.source.startswith("p. ") or claim.figure in run.figures, claim
            assert claim.not_testable is None or claim.reason is None


@every_procedure
def test_claims_of_a_procedure_name_its_own_figures_and_tables(procedure: ProcedureSettings) -> None:
    figures = set(procedure.figures.values())
    for name in procedure.runs.values():
        figures |= set(load_plan(name).figures) if name in packaged_runs() else set()
    for claim in procedure.claims:
        assert re.match(r"p\. \d|Figs?\. \d|Table \d|axis of Fig\. \d", claim.source), claim
        assert claim.not_testable is None or claim.reason is None
        for kind, number in re.findall(r"(Figs?\.|Table|,) (\d\.\d+)", claim.source):
            assert number in ({procedure.table} if kind == "Table" else figures), claim


def test_every_table_of_constants_belongs_to_one_procedure() -> None:
    assert sorted(procedure.table for procedure in PROCEDURES.values() if procedure.table) == [
        "4.2", "4.3", "5.2", "5.3"]


@every_procedure
def test_what_a_procedure_is_made_from_is_in_the_package(procedure: ProcedureSettings) -> None:
    stage = ESTIMATED_STAGES[procedure.name[:4]]
    for part, name in procedure.runs.items():
        if part == "parabolas":
            assert PROCEDURES[name].kind == "parabolas"
        else:
            assert packaged_runs()[name].startswith(stage.name)
    assert set(procedure.printed) <= set(stage.constants)
    for claim in procedure.claims:
        assert claim.constant is None or claim.constant in stage.constants
        if claim.quantity == "constant" and claim.constant in procedure.printed:
            assert claim.target == procedure.printed[claim.constant][1], "the table's column of ε = 0.01"


def test_no_two_scenarios_say_different_things_of_one_procedure() -> None:
    for run in RUNS:
        assert run.procedure is None or run.procedure == PROCEDURES[run.procedure.name]
    assert not set(PROCEDURES) & set(packaged_runs())


def test_comparisons_name_what_the_other_run_has() -> None:
    for run in RUNS:
        for claim in run.claims:
            if claim.than is not None:
                other = load_plan(claim.than)
                axes = [claim.than_axis] if claim.than_axis else claim.axes or run.axes
                assert set(axes) <= set(other.axes), claim
                assert set(other.metrics.bands) >= ({claim.band} if claim.band else set())


def test_every_law_has_a_smooth_run_that_is_checked_to_the_nanometre() -> None:
    smooth = [run for run in RUNS if "smooth" in run.name]
    assert {run.fmus["controller"].model for run in smooth} == {
        "Regulator2DOF", "LinearRegulator2DOF", "PID2DOF",
        "Regulator3DOF", "LinearRegulator3DOF", "ScheduledRegulator3DOF", "PID3DOF",
        "InterpolatedRegulator3DOF"}
    for run in smooth:
        assert run.fmus["plant"].start["encoder.resolution"].value == 0
        for axis in run.axes.values():
            assert run.check.signals[axis.position].absolute <= 1e-9
            assert run.check.signals[axis.position].relative == 0.0


def test_packaged_runs_start_from_estimates_of_their_own_stage() -> None:
    for stage, constants in (("2dof", ["C1", "C2", "C3", "C4"]), ("3dof", ["C1", "C2", "C3", "C4", "C5"])):
        run = load_plan(f"{stage}-identification-model")
        assert run.fmus["plant"].start_from == {
            name: RunOutput(run=f"{stage}-identification-rig", output=f"estimator_10ms.{name}") for name in constants}


def test_orderings_of_several_steps_or_axes_are_judged_by_the_median() -> None:
    """Or by the worst, where the thesis says "even the best"; never by the mean or by the best of them."""
    orderings = {(run.name, claim.text): claim for run in RUNS for claim in run.claims if claim.kind == "ordering"}
    assert len(orderings) > 20
    of_several = [claim for (name, _), claim in orderings.items() if claim.quantity in ("settling_time", "overshoot")
                  and "pid-small" not in name]
    assert len(of_several) > 10 and {claim.over for claim in of_several} == {"median"}
    assert {claim.over for claim in orderings.values()} == {"all", "median"}


def test_sentences_by_which_something_was_chosen_say_so() -> None:
    """The sentences that the scale of friction was fitted to, and all about the PID."""
    chose = {run.name: {claim.chose for claim in run.claims if claim.figure is None and claim.quantity is not None}
             for run in RUNS}
    friction = {name for name, found in chose.items() if any("friction" in str(each) for each in found)}
    assert friction == {*read_settings().training}
    pids = {run.name for run in RUNS if run.claims and "PID" in str(run.fmus["controller"].model)}
    assert pids and all("poles of the PID" in str(each) for name in pids for each in chose[name])
    assert not any(claim.chose for claim in load_plan("2dof-tracking-friction-compensation").claims)
