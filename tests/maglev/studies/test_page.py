"""What a study says: Sobol indices against an analytic function, worst samples, the page."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from tiny_study import fly_samples, planned, tiny

from maglev.studies.design import unit_samples
from maglev.studies.page.page import page
from maglev.studies.page.sensitivity import sensitivity

ABOUT: dict[str, Any] = {
    "name": "study", "title": "<b>odd</b>", "description": "", "scenario": "tiny", "correlated": [], "limits": {},
    "design": {"kind": "saltelli", "samples": 1024, "seed": 1}, "targets": ["plant.a", "plant.b"],
    "vary": [{"name": "plant.a", "set": ["plant.a"]}, {"name": "plant.b", "set": ["plant.b"]}],
    "run": {"scenario": "tiny.toml", "set": {}, "options": {}},
    "provenance": {"version": "0", "commit": None, "python": "3", "fmus": [], "changes": []}}


def table(values: np.ndarray[Any, Any], points: np.ndarray[Any, Any], failure: str | None = None) -> pa.Table:
    number = len(values)
    roles = {"plant.a": b"varied", "plant.b": b"varied", "overshoot of v": b"metric"}
    columns = {"sample": range(number), "plant.a": points[:, 0], "plant.b": points[:, 1], "overshoot of v": values,
               "failed": [False] * number, "passed": [True] * number,
               "failure": pa.array([failure] + [None] * (number - 1), pa.string())}
    made = pa.table(columns)
    return made.cast(pa.schema([field.with_metadata({b"unit": b"", b"role": roles.get(field.name, b"")})
                                for field in made.schema]))


def points() -> np.ndarray[Any, Any]:
    vary = [{"set": name, "kind": "uniform", "low": 0, "high": 1} for name in ("plant.a", "plant.b")]
    return unit_samples(tiny(vary=vary, design={"kind": "saltelli", "samples": 1024}))


def test_sobol_indices_of_a_linear_function() -> None:
    """y = 2 a + b: var y = (4 + 1)/12, so that S_a = 0.8 and S_b = 0.2, first order and total."""
    at = points()
    found, notes = sensitivity(table(2 * at[:, 0] + at[:, 1], at), ABOUT)
    assert not notes
    for indices in (found[0].first, found[0].total):
        assert indices == pytest.approx({"plant.a": 0.8, "plant.b": 0.2}, abs=0.01)


def test_sobol_indices_of_a_product() -> None:
    """y = (a - 1/2)(b - 1/2) has no first-order effects; each is in all of the variance."""
    at = points()
    (found,), _ = sensitivity(table((at[:, 0] - 0.5) * (at[:, 1] - 0.5), at), ABOUT)
    assert found.first == pytest.approx({"plant.a": 0.0, "plant.b": 0.0}, abs=0.02)
    assert found.total == pytest.approx({"plant.a": 1.0, "plant.b": 1.0}, abs=0.05)


@pytest.mark.parametrize(("about", "failure", "words"), [
    ({"design": {"kind": "sobol", "samples": 8, "seed": 0}}, None, "need a design of kind 'saltelli'"),
    ({"correlated": [["plant.a", "plant.b"]]}, None, "correlated"), ({}, "refused", "need every sample")])
def test_where_there_are_no_indices_it_says_why(about: dict[str, Any], failure: str | None, words: str) -> None:
    at = points()
    found, (note,) = sensitivity(table(at[:, 0], at, failure), {**ABOUT, **about})
    assert not found
    assert words in note


def test_what_never_settled_has_no_indices() -> None:
    at = points()
    values = at[:, 0].copy()
    values[3] = np.inf
    found, (note,) = sensitivity(table(values, at), ABOUT)
    assert not found
    assert note.startswith("None of overshoot of v: not finite")


def test_the_page_names_the_worst_sample_and_its_command(fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus, title="a <b> title",
                    vary=[{"set": "plant.v.mass", "kind": "list", "values": [4.0, 4.35, 5.0]}],
                    limits={"rms error of v": {"max": "1 um"}})
    made = study.layout.table(fly_samples(study.job, 0, study.values), study.design, study.values)
    text = page(made, study.layout.about)
    worst = int(np.argmax(made["rms error of v"].to_numpy()))
    assert f'<th scope="row">{worst}</th><td>largest rms error of v' in text
    assert f"maglev run tiny.toml --set plant.v.mass={[4.0, 4.35, 5.0][worst]}" in text
    assert "0 of 3 samples pass" in text and "a &lt;b&gt; title" in text
    found = json.loads(re.search(r'id="data">(.*?)</script>', text).group(1))   # type: ignore[union-attr]
    drawn = {column["name"]: column for column in found["columns"]}
    assert drawn["rms error of v"]["limits"] == {"max": 1e-3}
    assert drawn["rms error of v"]["values"] == pytest.approx(1e3 * made["rms error of v"].to_numpy(), rel=1e-5)
    assert found["varied"] == 1 and found["passed"] == [0, 0, 0]
