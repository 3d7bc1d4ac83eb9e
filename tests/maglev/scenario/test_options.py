"""The record of options: every signature, command and message follows it."""

import inspect
import typing
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
import typer
from command_line import error_line
from command_line import maglev as command
from facts import raises

import maglev
from maglev.cli.app import app
from maglev.cosim.isolated_run import TIMEOUT
from maglev.runs.execution import RunResult
from maglev.runs.preparation import Experiment
from maglev.scenario.options import OPTIONS, RunOptions, completed_options

# What a function does not take, for it says nothing there: baselines have a step, samples no files of start values.
LEFT_OUT = {"run": set(), "run_all": set(), "compare": {"controller"}, "check": {"step", "order"},
            "update": {"step", "order"}, "study": {"timeout", "parameters"}, "tune": {"timeout", "parameters"},
            "batch": {"timeout", "parameters"}}


@pytest.mark.parametrize("name", LEFT_OUT)
def test_a_signature_has_the_options(name: str) -> None:
    parameters = inspect.signature(getattr(maglev, name)).parameters
    assert not any(each.kind is inspect.Parameter.VAR_KEYWORD for each in parameters.values())
    for option, record in OPTIONS.items():
        assert (option in parameters) == (option not in LEFT_OUT[name]), option
        if option in parameters:
            assert parameters[option].default == record.default
            assert parameters[option].kind is inspect.Parameter.KEYWORD_ONLY


def test_other_functions_have_the_same_defaults() -> None:
    for name in maglev.__all__:
        if name == "build" or not inspect.isfunction(getattr(maglev, name)):
            continue   # a build makes Python FMUs into a folder of its own
        for option, parameter in inspect.signature(getattr(maglev, name)).parameters.items():
            if option in OPTIONS and option not in ("controller", "plant", "step") and name not in LEFT_OUT:
                default = OPTIONS[option].default
                assert parameter.default == (TIMEOUT if option == "timeout" else default), f"{name}: {option}"


def test_the_types_of_the_record_exist() -> None:
    from maglev.scenario.settings import Settings
    from maglev.user.source import Given

    names = {"Given": Given, "Settings": Settings}
    assert typing.get_type_hints(RunOptions, localns=names).keys() == OPTIONS.keys()


def test_commands_have_the_flags_and_defaults() -> None:
    commands = typer.main.get_command(app).commands   # type: ignore[attr-defined]
    for name in ("run", "report", "compare", "check", "study", "tune"):
        flags = {flag: each for each in commands[name].params for flag in each.opts}
        for option, record in OPTIONS.items():
            if option not in LEFT_OUT[{"report": "run_all"}.get(name, name)]:
                assert flags[record.flag].name == option and flags[record.flag].default == record.default
                assert record.help.split("`")[0] in (flags[record.flag].help or "")


def test_defaults_are_completed_and_times_read() -> None:
    assert completed_options({})["timeout"] == TIMEOUT
    assert completed_options({"step": "0.2 ms"})["step"] == 0.2e-3
    assert completed_options({"fmi": 3}) == {**completed_options({}), "fmi": 3}


@pytest.mark.parametrize(("options", "facts"), [
    ({"step": -1}, ["step", -1]), ({"keep_settings": True}, ["keep_settings", "controller", "plant"]),
    ({"set": {"plant.v.mas": 7}}, ["plant.v.mas", 7, "'v.mass'"]), ({"timeout": "3 kg"}, ["timeout", "3 kg"])])
def test_messages_are_the_same_in_python_and_on_the_command_line(options: RunOptions, facts: list[object],
                                                                 fastest_fmus: Path, tmp_path: Path) -> None:
    given: RunOptions = {**options, "fmus": fastest_fmus}
    with raises(maglev.ScenarioError, *facts) as refused:
        maglev.run("2dof-setpoints", **given)
    words: list[str] = []
    for name, value in options.items():
        values = [f"{key}={each}" for key, each in value.items()] if isinstance(value, dict) else [str(value)]
        words += [OPTIONS[name].flag, *([] if value is True else values)]
    said = error_line(command("run", "2dof-setpoints", "--fmus", fastest_fmus, "--out", tmp_path, *words))
    assert said == f"maglev: {refused.value}"


def test_values_of_ones_own_bring_no_runs_to_compare_with(fastest_fmus: Path, tmp_path: Path,
                                                          monkeypatch: pytest.MonkeyPatch) -> None:
    """The thesis's claims are not judged then; what they compare with may be of a stage without such a parameter."""
    made: list[str] = []

    def noted(experiments: Sequence[Experiment], *_: object) -> list[RunResult]:
        made[:] = [experiment.plan.name for experiment in experiments]
        return []

    def names(**options: Any) -> list[str]:
        maglev.run_all(["3dof-tracking-nonlinear"], out=tmp_path, fmus=fastest_fmus, **options)
        return [*made]

    monkeypatch.setattr("maglev.api.running.run_experiments", noted)

    own = {"plant.x.friction.coulomb": 0.0}
    assert names(set=own) == ["3dof-tracking-nonlinear"]
    assert "2dof-tracking-nonlinear" in names()
