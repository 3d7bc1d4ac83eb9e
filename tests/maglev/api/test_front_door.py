"""`import maglev`: its public names, its examples, and runs as data."""

import doctest
import re
import subprocess
import sys
import warnings
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from facts import raises, require_facts

import maglev
from maglev.cosim.master import RunFailed
from maglev.files.errors import ControllerError, LinearModelError, ScenarioError, StabilityError
from maglev.scenario.layers import packaged_runs

MODULES = sorted({"maglev", *maglev.MODULES.values()})


def test_public_names() -> None:
    """Every name of `__all__` is there and documented, and nothing else is public by accident."""
    assert maglev.__all__ == sorted(maglev.__all__)
    for name in maglev.__all__:
        assert getattr(maglev, name).__doc__, name
    assert dir(maglev) == maglev.__all__
    assert re.fullmatch(r"\d+\.\d+\.\d+", maglev.__version__)
    with raises(AttributeError, "'runn'"):
        _ = maglev.runn   # type: ignore[attr-defined]


def test_an_option_that_does_not_exist_is_refused() -> None:
    calls: list[tuple[Any, Any]] = [(maglev.run, "2dof-smooth-nonlinear"), (maglev.check, ["2dof-smooth-nonlinear"]),
                                    (maglev.run_all, ["2dof-smooth-nonlinear"])]
    for call, what in calls:
        with raises(maglev.ScenarioError, "kin", "'kind'"):
            call(what, kin="native")


@pytest.mark.parametrize(("function", "given", "options", "kind", "facts"), [
    (maglev.run, ["2dof-smooth-nonlinear"], {}, ScenarioError, ["scenario", "['2dof-smooth-nonlinear']"]),
    (maglev.run, "2dof-smooth-nonlinear", {"controller": abs}, ControllerError, ["<built-in function abs>", "step"]),
    (maglev.compare, ["2dof-smooth-nonlinear", "2dof-smooth-linear"], {}, ScenarioError,
     ["runs", "'2dof-smooth-nonlinear'"]),
    (maglev.run, "2dof-smooth-nonlinear", {"set": [("plant.v.mass", 4.0)]}, ScenarioError,
     ["set", "('plant.v.mass', 4.0)", "table"]),
    (maglev.run, "2dof-smooth-nonlinear", {"set": {4: 4.0}}, ScenarioError, ["set", "4 = 4.0", "FMU.variable=value"]),
    (maglev.run_all, "2dof-smooth-nonlinear", {"format": "xls"}, ScenarioError, ["format", "xls", "csv", "parquet"]),
    (maglev.batch, "2dof-smooth-nonlinear", {"values": ["plant.v.mass"]}, ScenarioError,
     ["values", "['plant.v.mass']", "table"]),
    (maglev.study, "2dof-smooth-nonlinear", {"vary": {4: [4.0]}}, ScenarioError, ["vary", "{4: [4.0]}", "table"]),
    (maglev.linearise, "Plant3DOF", {"at": "25 mm"}, LinearModelError, ["Plant3DOF", "at", "'25 mm'", "table"]),
    (maglev.linearise, "Plant3DOF", {"at": {"y": 0.02}, "parameters": "y.mass=7"}, LinearModelError,
     ["Plant3DOF", "parameters", "'y.mass=7'", "table"]),
    (maglev.region, "3dof", {"axis": "y", "gap": 0.02, "set": "plant.y.mass=7"}, StabilityError,
     ["set", "'plant.y.mass=7'", "table"]),
    (maglev.compare, [], {}, ScenarioError, ["runs", "empty", "two"]),
    (maglev.compare, "2dof-smooth-nonlinear", {"controllers": [None]}, ScenarioError, ["controllers", "None"]),
    (maglev.compare, "2dof-smooth-nonlinear", {"controllers": {1: "PID2DOF"}}, ScenarioError,
     ["controller", "PID2DOF", "label", "1"]),
    (maglev.run_all, "2dof-smooth-nonlinear", {"plot": "no"}, ScenarioError, ["plot", "no", "True", "False"]),
    (maglev.run, "2dof-smooth-nonlinear", {"keep_settings": "no"}, ScenarioError,
     ["keep_settings", "no", "True", "False"]),
    (maglev.tune, {"name": "mine"}, {}, ScenarioError, ["tuning file", "{'name': 'mine'}"]),
    (maglev.linearise_loop, "Plant3DOF", {"controller": None, "at": {"y": 0.025}}, LinearModelError, ["None"])])
def test_refuses_an_argument_of_another_type_by_its_name(
        function: Callable[..., object], given: Any, options: dict[str, Any], kind: type[maglev.MaglevError],
        facts: list[str]) -> None:
    with raises(kind, *facts):
        function(given, **options)


def test_warnings_are_at_the_line_of_the_caller(fastest_fmus: Path) -> None:
    with pytest.warns(UserWarning) as said:
        maglev.batch("2dof-step-1-linear", {"plant.v.mass": [4.3]}, controller=fastest_fmus / "PID2DOF.fmu",
                     fmus=fastest_fmus)
        maglev.run("2dof-step-1-linear", controller=fastest_fmus / "PID2DOF.fmu", fmus=fastest_fmus)
    assert {warning.filename for warning in said} == {__file__}
    require_facts([str(warning.message) for warning in said], "controller", "PID2DOF.fmu")


def test_every_error_has_one_root() -> None:
    errors = import_module("maglev.files.errors")
    found = [each for each in vars(errors).values() if isinstance(each, type) and issubclass(each, Exception)]
    assert len(found) > 8
    assert all(issubclass(each, maglev.MaglevError) for each in [*found, RunFailed])


def test_importing_is_light() -> None:
    """Who imports the package waits for none of the libraries."""
    code = "import sys, maglev; print(*sorted({'numpy', 'scipy', 'fmpy', 'pydantic', 'rich'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("module", [
    pytest.param(name, marks=pytest.mark.thorough) if name == "maglev.analysis.region" else name   # it takes seconds
    for name in MODULES])
def test_examples(module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert doctest.testmod(import_module(module)).failed == 0


def test_there_are_examples() -> None:
    functions = [getattr(maglev, name) for name in maglev.__all__]
    shown = [each.__name__ for each in functions if ">>>" in (each.__doc__ or "")]
    assert {"build", "check", "fmus", "run", "scenarios"} <= set(shown)


@pytest.fixture(scope="module")
def run(fastest_fmus: Path) -> maglev.Run:
    return maglev.run("2dof-smooth-nonlinear", fmus=fastest_fmus)


def test_a_run_as_data(run: maglev.Run) -> None:
    assert run.name == "2dof-smooth-nonlinear"
    assert run.time[0] == 0.0
    assert np.all(np.diff(run.time) > 0.0)
    assert run["plant.v.position"].shape == run.time.shape
    assert run.units["plant.v.position"] == "m"
    # The metrics are those of the columns.
    error = abs(run["plant.v.position"][-1] - run["controller.v.reference"][-1])
    assert run.metrics.end_errors["v"] == pytest.approx(error, abs=1e-12)
    assert run.parameters["plant.v.mass"] > 0.0
    assert [verdict.claim for verdict in run.verdicts] == run.plan.claims
    assert repr(run).startswith("<Run 2dof-smooth-nonlinear: ")


def test_a_column_that_is_not_there(run: maglev.Run) -> None:
    with raises(maglev.UnknownName, "'plant.v.positon'", "'plant.v.position'"):
        _ = run["plant.v.positon"]


def test_what_is_no_name_is_no_column(run: maglev.Run) -> None:
    assert 0 not in run
    with raises(maglev.UnknownName, 0):
        _ = run[0]   # type: ignore[index]


def test_tables_of_others(run: maglev.Run, tmp_path: Path) -> None:
    frame, data = run.to_pandas(), run.to_xarray()
    for name, values in run.columns.items():
        assert np.array_equal(frame[name].to_numpy(), values)
        assert np.array_equal(data[name].to_numpy(), values)
    assert np.array_equal(frame.index.to_numpy(), run.time)
    assert data["plant.v.position"].attrs["units"] == frame.attrs["units"]["plant.v.position"] == "m"
    run.to_csv(tmp_path / "run.csv")
    header = (tmp_path / "run.csv").read_text().partition("\n")[0]
    assert header.split(",") == ["time", *run.columns]


def test_a_picture(run: maglev.Run) -> None:
    titles = [panel.get_ylabel() for panel in run.plot().axes]
    assert "gap v (mm)" in titles
    assert any("currents" in title for title in titles)


@pytest.mark.parametrize("value", [0.0, "0 N", "0"])
def test_settings(fastest_fmus: Path, run: maglev.Run, value: float | str) -> None:
    """Numbers and text are one; and they do something."""
    changed = maglev.run("2dof-smooth-nonlinear", fmus=fastest_fmus, set={"plant.h.friction.coulomb": value})
    assert changed.parameters["plant.h.friction.coulomb"] == 0.0
    assert not np.array_equal(changed["plant.h.position"], run["plant.h.position"])


def test_boolean_settings(fastest_fmus: Path) -> None:
    plain = maglev.run("2dof-smooth-nonlinear", fmus=fastest_fmus, set={"controller.antiwindup": False})
    assert plain.time[-1] > 0.0


def test_what_cannot_be_run_alone(fastest_fmus: Path) -> None:
    with raises(maglev.ScenarioError, "2dof-step-4", "2dof-step-4-nonlinear"):
        maglev.run("2dof-step-4", fmus=fastest_fmus)
    with raises(maglev.ScenarioError, "2dof-identification-rig", "run_all"):
        maglev.run("2dof-identification-model", fmus=fastest_fmus)


def test_what_is_put_in_is_warned_about(fastest_fmus: Path) -> None:
    """A plan's start values that another controller does not have are said once, as a warning."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        simulated = maglev.run("2dof-setpoints", fmus=fastest_fmus, controller=fastest_fmus / "PID2DOF.fmu")
    require_facts([str(warning.message) for warning in caught], "controller", "PID2DOF.fmu", "v.k1")
    assert simulated.time[-1] > 0.0


def test_scenarios_and_fmus() -> None:
    assert [entry.name for entry in maglev.scenarios()] == list(packaged_runs())
    assert all(entry.title for entry in maglev.scenarios())
    assert all(entry.description for entry in maglev.fmus())


def test_many_runs(fastest_fmus: Path, tmp_path: Path) -> None:
    told: list[str] = []
    results = maglev.run_all(["2dof-smooth"], out=tmp_path, fmus=fastest_fmus, jobs=2, say=told.append)
    assert [each.plan.name for each in results.runs] == list(results.asked)
    assert {path.name for path in results.files} == {path.name for path in tmp_path.iterdir()}
    assert told == []


def test_baselines_have_a_step_of_their_own(fastest_fmus: Path) -> None:
    with raises(maglev.ScenarioError, "step", "0.001", "check"):
        maglev.check(["2dof-smooth"], fmus=fastest_fmus, step=1e-3)   # type: ignore[call-arg]
