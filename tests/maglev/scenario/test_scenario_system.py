"""A run as a system of FMUs: what masters of others find in its files. That one of them runs it is asked elsewhere."""

from pathlib import Path

import pytest
from facts import raises
from fmpy import read_model_description
from fmpy.ssp.ssd import read_ssd, read_ssv
from interop.loops import files_in

import maglev
from maglev.cosim.master import FmuSetup

NAME = "3dof-thrust-loss-loose"


@pytest.fixture(scope="module")
def system(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path, values = maglev.build(ssp=NAME, fmus=tmp_path_factory.mktemp("systems"))
    assert (path.name, values.name) == (f"{NAME}.ssp", f"{NAME}.ssv")
    return path


def test_inputs_driven_by_signals_become_system_inputs(system: Path) -> None:
    """Outputs that are called as one of them stay within."""
    described = read_ssd(str(system))
    ports = {kind: {each.name for each in described.system.connectors if each.kind == kind}
             for kind in ("input", "output")}
    axes = ("y", "x", "z")
    assert ports["input"] >= {"C1", *(f"{axis}.{what}" for axis in axes for what in ("reference", "reference_rate"))}
    assert "alpha.i_a" in ports["output"] and not ports["input"] & ports["output"]
    assert [part.name for part in described.system.elements] == ["controller", "plant", "estimator"]


def test_parameters_that_are_fed_are_inputs(system: Path) -> None:
    described = {name: read_model_description(str(files_in(system, FmuSetup(name, Path(f"{model}.fmu")))))
                 for name, model in (("controller", "Regulator3DOF"), ("plant", "Plant3DOF"),
                                     ("estimator", "Estimator3DOF"))}
    kinds = {name: {variable.name: variable.causality for variable in each.modelVariables}
             for name, each in described.items()}
    assert {name for name, kind in kinds["controller"].items() if kind == "input" and name[0] == "C"} == {
        "C1", "C2", "C3", "C4"}
    assert kinds["controller"]["C5"] == "parameter" and kinds["plant"]["C1"] == "input" == kinds["estimator"]["held"]
    commands = next(each for each in described["controller"].outputs if each.variable.name == "alpha.i_d_cmd")
    assert {"C1", "C4"} <= {each.name for each in commands.dependencies}
    first = next(each for each in described["controller"].modelVariables if each.name == "C1")
    assert float(first.min) == 0.0 < float(first.start)


def test_what_the_run_sets_is_in_both_files(system: Path) -> None:
    values = {each.name: each.value for each in read_ssv(str(system.with_suffix(".ssv"))).parameters}
    assert float(values["estimator.C5_weight"]) == 1e12 and values["estimator.matched_filter"] == "true"
    assert "plant.y.mass" not in values
    within = {f"{part.name}.{each.name}": each.value for part in read_ssd(str(system)).system.elements
              for binding in part.parameterBindings for set_ in binding.parameterValues for each in set_.parameters}
    assert values.items() <= within.items() and "plant.y.mass" in within


@pytest.mark.parametrize(("table", "facts"), [
    ('[fmus.controller]\nfile = "mine.fmu"\n', ["fmus.controller.file", "mine.fmu", "`model`"]),
    ('[fmus.controller.start_from]\nC1 = { run = "2dof-push", output = "plant.v.position" }\n',
     ["fmus.controller.start_from", "`start`"]),
    ('[fmus.controller.inputs]\nomega0 = "plant.y.encoder"\n', ["controller.omega0", "fixed", "tunable"])])
def test_names_parts_that_a_system_cannot_have(tmp_path: Path, table: str, facts: list[str]) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(f'extends = ["loops/3dof.toml"]\nname = "mine"\ntitle = "Mine"\nstop_time = "1 s"\n{table}',
                    encoding="utf-8")
    with raises(maglev.BuildError, path, *facts):
        maglev.build(ssp=path, fmus=tmp_path)
    assert [*tmp_path.iterdir()] == [path]


def test_a_run_is_not_built_with_others(tmp_path: Path) -> None:
    with raises(maglev.ScenarioError, "ssp", "2dof-push", "names", "stage"):
        maglev.build(["PID3DOF"], ssp="2dof-push", fmus=tmp_path)
