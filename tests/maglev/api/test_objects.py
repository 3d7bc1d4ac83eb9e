"""Objects where files can stand: scenarios as tables, recordings as columns, controllers as classes and objects."""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from facts import raises
from identification_data import Data, record, trial
from written_controllers import PD, controller
from written_controllers import trial as scenario

import maglev
from maglev.files.errors import ControllerError, CsvError, MaglevError, ScenarioError

NAME = "2dof-smooth-nonlinear"
TABLE = {"extends": "loops/2dof.toml", "name": "short", "title": "A short hold", "stop_time": "20 ms",
         "fmus": {"plant": {"start": {"v.position_start": np.float64(0.021), "h.position_start": 0}}},
         "signals": [{"to": "controller.v.reference", "kind": "constant", "value": "21 mm"}]}


@pytest.fixture(scope="module")
def pd(tmp_path_factory: pytest.TempPathFactory) -> Any:
    names: dict[str, Any] = {"__name__": "notebook"}
    exec(PD, names)
    return names["PD"]


def test_a_scenario_as_a_table(fastest_fmus: Path, tmp_path: Path) -> None:
    run = maglev.run(TABLE, fmus=fastest_fmus)
    assert run.name == "short"
    assert run["plant.v.position"][0] == 0.021
    many = maglev.run_all([TABLE, NAME], fmus=fastest_fmus, out=tmp_path, jobs=1)
    assert list(many) == ["short", NAME]
    assert np.array_equal(many["short"]["plant.v.position"], run["plant.v.position"])


@pytest.mark.parametrize(("change", "facts"), [
    ({"stop_tim": "1 s"}, ["table short", "stop_tim", "'stop_time'"]), ({"title": {1, 2}}, ["table", "{1, 2}", "TOML"]),
    ({"name": 5}, ["table 5", "name", "5", "string"])])
def test_a_table_that_is_no_scenario(change: dict[str, Any], facts: list[str]) -> None:
    with raises(ScenarioError, *facts):
        maglev.run({**TABLE, **change})


def test_two_tables_of_one_name_are_refused(fastest_fmus: Path, tmp_path: Path) -> None:
    with raises(ScenarioError, "name", "'short'"):
        maglev.run_all([TABLE, {**TABLE, "stop_time": "30 ms"}], fmus=fastest_fmus, out=tmp_path)


def test_a_check_takes_a_name(fastest_fmus: Path) -> None:
    result, = maglev.check(NAME, fmus=fastest_fmus, jobs=1)
    assert (result.name, result.status) == (NAME, "passed")


@pytest.fixture(scope="module")
def recorded() -> dict[str, np.ndarray]:
    return columns_of(trial("2dof", "encoder"))


def columns_of(data: Data) -> dict[str, np.ndarray]:
    recording = data.recording
    return {"t": recording.time, "gap": recording.positions[:, 0], "along": recording.positions[:, 1],
            "d": recording.i_d[:, 0], "q": recording.i_q[:, 0]}


COLUMNS = {"time": "t", "v": "gap", "h": "along", "i_d": "d", "i_q": "q"}


@pytest.mark.thorough
def test_columns_are_identified_as_their_file_is(recorded: dict[str, np.ndarray], tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    np.savetxt(tmp_path / "a.csv", np.column_stack(list(recorded.values())), delimiter=",",
               header=",".join(recorded), comments="", fmt="%.17g")
    expected = maglev.identify(tmp_path / "a.csv", columns=COLUMNS).estimate.final
    ours = {name: recorded[own] for name, own in COLUMNS.items()}
    for given, columns in ((recorded, COLUMNS), (ours, None), (pandas.DataFrame(recorded), COLUMNS),
                           (pandas.DataFrame(ours).set_index("time"), None)):
        assert maglev.identify(given, columns=columns).estimate.final == expected


@pytest.mark.usefixtures("slow")
def test_columns_that_cannot_be_used() -> None:
    recorded = columns_of(record("2dof", 1.5, 0.5e-3))
    bad: list[tuple[Any, dict[str, str], type[MaglevError], list[str]]] = [
        ({**recorded, "gap": recorded["gap"][1:]}, {}, CsvError, ["data", "gap", f"({len(recorded['gap']) - 1},)"]),
        ({**recorded, "d": np.nan * recorded["d"]}, {}, CsvError, ["data", "row 0", "d", "'nan'"]),
        (recorded, {"v": "gab"}, CsvError, ["columns", "v='gab'", "'gap'"]),
        ({**recorded, "gap": 1e3 * recorded["gap"]}, {}, CsvError, ["row 0", "gap", "20", "gap = mm"]),
        (5, {}, CsvError, ["int", "path"])]
    for data, columns, kind, facts in bad:
        with raises(kind, *facts):
            maglev.identify(data, columns={**COLUMNS, **columns})


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_an_object_runs_as_it_is(fastest_fmus: Path, tmp_path: Path, pd: Any) -> None:
    """Each run begins with a copy of it; two objects of one class are two controllers."""
    base = pd()
    weak, plain = pd(), pd()
    name = next(each for each in pd.parameters if isinstance(getattr(weak, each, None), float))
    setattr(weak, name, 0.9 * getattr(weak, name))
    path = scenario(tmp_path)
    of_class = maglev.run(path, controller=pd, fmus=fastest_fmus)
    compared = maglev.compare(path, {"plain": plain, "weak": weak}, fmus=fastest_fmus)
    column = "plant.v.position"
    assert np.array_equal(compared.runs["plain"][column], of_class[column])
    assert not np.array_equal(compared.runs["weak"][column], of_class[column])
    assert {key: value for key, value in vars(plain).items() if isinstance(value, float)} == {
        key: value for key, value in vars(base).items() if isinstance(value, float)}


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_many_runs_of_a_class(fastest_fmus: Path, tmp_path: Path, pd: Any) -> None:
    results = maglev.run_all([scenario(tmp_path), NAME], controller=pd, fmus=fastest_fmus, out=tmp_path, jobs=2)
    assert not [each.failure for each in results.runs if each.failure]
    assert next(iter(results)) == "trial"


def test_refuses_objects_that_cannot_be_copied(fastest_fmus: Path, tmp_path: Path, pd: Any) -> None:
    held = pd()
    held.file = (tmp_path / "log").open("w")
    with held.file, raises(ControllerError, "PD", "pickle"):
        maglev.run(scenario(tmp_path), controller=held, fmus=fastest_fmus)


@pytest.mark.usefixtures("slow")
def test_a_class_is_built_from_its_file(tmp_path: Path, pd: Any) -> None:
    spec = spec_from_file_location("of_a_file", controller(tmp_path))
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    import sys
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "of_a_file", module)   # as an import has it
        file, = maglev.build(module.PD, fmus=tmp_path)
        assert file.name == "PD.fmu"
        with raises(ControllerError, "PD", "module", "file"):
            maglev.build(module.PD(), fmus=tmp_path)
    with raises(ControllerError, "PD", "module", "file"):
        maglev.build(pd, fmus=tmp_path)
