"""What a notebook shows and what it can do with results: mappings, short texts, tables and pictures."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from facts import raises

import maglev
from maglev.files.errors import ScenarioError, UnknownName

PNG = b"\x89PNG\r\n\x1a\n"
NAME = "2dof-smooth-nonlinear"
SHORT = 300   # characters of a text that fits a cell


@pytest.fixture(scope="module")
def run(fastest_fmus: Path) -> maglev.Run:
    return maglev.run(NAME, fmus=fastest_fmus)


@pytest.fixture(scope="module")
def results(fastest_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> maglev.Results:
    return maglev.run_all(["2dof-smooth"], fmus=fastest_fmus, out=tmp_path_factory.mktemp("results"), jobs=1)


def test_a_run_is_a_mapping_of_its_columns(run: maglev.Run) -> None:
    assert list(run) == list(run.keys()) == list(run.columns)
    assert len(run) == len(run.columns)
    assert "plant.v.position" in run
    assert "plant.v.positon" not in run
    assert run.get("plant.v.positon") is None
    assert all(values is run[name] for name, values in run.items())
    assert run == run
    assert len({run, run}) == 1


def test_results_are_a_mapping_of_runs(results: maglev.Results, run: maglev.Run) -> None:
    assert list(results) == list(results.asked)
    found = results[NAME]
    assert np.array_equal(found["plant.v.position"], run["plant.v.position"])
    assert found.units == run.units
    with raises(UnknownName, "'2dof-smoth-pid'", "'2dof-smooth-pid'"):
        _ = results["2dof-smoth-pid"]


def test_a_run_that_did_not_complete_says_why(fastest_fmus: Path, tmp_path: Path) -> None:
    results = maglev.run_all([NAME], fmus=fastest_fmus, out=tmp_path, jobs=1, timeout="10 s",
                             controller=controller_that_fails(tmp_path))
    assert list(results) == []
    assert len(results) == 0
    with raises(UnknownName, NAME, "no such gain"):
        _ = results[NAME]


def controller_that_fails(folder: Path) -> Path:
    text = maglev.new_controller(folder / "failing.py", stage="2dof").read_text(encoding="utf-8")
    step = "    def step(self, t: float) -> None:"
    (folder / "failing.py").write_text(text.replace(step, f"{step}\n        raise ValueError('no such gain')", 1),
                                       encoding="utf-8")
    return folder / "failing.py"


def test_texts_are_short(run: maglev.Run, results: maglev.Results, fastest_fmus: Path, tmp_path: Path) -> None:
    linear = maglev.linearise("Plant2DOF", {"v": "20 mm"})
    assert len(repr(linear.equilibrium)) < SHORT
    for shown in (run, results, results.runs[0], linear, *maglev.check(NAME, fmus=fastest_fmus, jobs=1),
                  *maglev.update(NAME, fmus=fastest_fmus, jobs=1, baselines=tmp_path),
                  maglev.stage(maglev.new_stage(tmp_path / "mine.toml")[0])):
        assert repr(shown).startswith(f"<{type(shown).__name__} ") or repr(shown).startswith("<Results: ")
        assert len(repr(shown)) < SHORT
    assert f"{NAME}: completed" in repr(results)


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("what", ["run", "results"])
def test_tables_in_html(what: str, request: pytest.FixtureRequest) -> None:
    shown = request.getfixturevalue(what)
    text = shown._repr_html_()
    assert text.startswith("<pre")
    assert text.rstrip().endswith("</pre>")
    assert NAME in text
    assert "<script" not in text


def test_a_text_in_html_is_no_html(run: maglev.Run, monkeypatch: pytest.MonkeyPatch) -> None:
    title = "a <b>bold</b> title & more"
    monkeypatch.setitem(vars(run), "result", replace(run.result, plan=run.plan.model_copy(update={"title": title})))
    assert "a &lt;b&gt;bold&lt;/b&gt; title &amp; more" in run._repr_html_()


def test_tables_go_to_files_in_a_notebook(run: maglev.Run, fastest_fmus: Path, tmp_path: Path,
                                         monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """A console of rich's, in a notebook, displays what it prints, and leaves the file empty that it prints to.

    With FORCE_COLOR, as on many servers, it takes a file for a terminal.
    """
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    monkeypatch.setenv("FORCE_COLOR", "1")
    maglev.run_all(NAME, fmus=fastest_fmus, out=tmp_path, jobs=1)
    for text in ((tmp_path / f"{NAME}.txt").read_text(encoding="utf-8"), run._repr_html_()):
        assert "Steps" in text and "\x1b" not in text
    assert capsys.readouterr().out == ""


def test_a_study_is_read_from_another_folder(fastest_fmus: Path, tmp_path: Path,
                                             monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    two: Any = np.int64(2)
    study = maglev.study(NAME, vary={"plant.v.mass": (4.0, 5.0)}, samples=two, fmus=fastest_fmus, jobs=1)
    monkeypatch.chdir(tmp_path.parent)
    assert study.path == Path("results", f"{study.name}.parquet")
    assert len(study.to_pandas()) == 2
    assert study.write_page() == tmp_path / "results" / f"{study.name}.html"


def test_pictures_show_themselves(run: maglev.Run, results: maglev.Results) -> None:
    """As PNG, without pyplot."""
    compared = maglev.compare({"one": run, "other": results[NAME]})
    drawn: tuple[Any, ...] = (run.plot(), compared.plot())
    for figure in drawn:
        assert figure._repr_png_().startswith(PNG)


def test_a_run_alone_is_not_compared(run: maglev.Run) -> None:
    with raises(ScenarioError, "runs", NAME, "two"):
        maglev.compare(run)
