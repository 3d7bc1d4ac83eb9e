"""Samples of a study: grids, points of quasi-random designs, distributions, correlation."""

from pathlib import Path

import numpy as np
import pytest
from facts import raises
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from tiny_study import tiny

from maglev.files.errors import ScenarioError
from maglev.many.study_design import samples, unit_samples
from maglev.many.study_file import FOLDER, load_study

MASS, FRICTION = "plant.v.mass", "plant.h.friction.coulomb"


def test_a_grid_is_every_combination_in_order() -> None:
    study = tiny(vary=[{"set": MASS, "kind": "grid", "from": "4 kg", "to": "5 kg", "number": 3},
                       {"set": FRICTION, "kind": "list", "values": [1, "2 N"]}])
    assert samples(study).tolist() == [[4.0, 1.0], [4.0, 2.0], [4.5, 1.0], [4.5, 2.0], [5.0, 1.0], [5.0, 2.0]]


@pytest.mark.parametrize(("low", "high", "number"), [("7 A", "8 A", 11), ("9 mm", "27 mm", 13), (0, "1.4 kg", 15)])
def test_values_of_a_grid_are_the_decimals_that_one_would_write(low: object, high: object, number: int) -> None:
    study = tiny(vary=[{"set": MASS, "kind": "grid", "from": low, "to": high, "number": number}])
    found = samples(study)[:, 0].tolist()
    assert max(len(repr(value)) for value in found) <= 6, found
    assert found == pytest.approx(np.linspace(found[0], found[-1], number), rel=1e-15, abs=0.0)


@pytest.mark.parametrize("kind", ["latin hypercube", "sobol", "halton", "saltelli"])
def test_a_design_is_its_seed_s(kind: str) -> None:
    vary = [{"set": MASS, "kind": "uniform", "low": 4, "high": 5}, {"set": FRICTION, "kind": "percent", "percent": 0.2}]
    first, again, other = (samples(tiny(vary=vary, design={"kind": kind, "samples": 64, "seed": seed}))
                           for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
    assert first[:, 0].min() >= 4.0 and first[:, 0].max() <= 5.0
    assert first[:, 1].min() >= 0.8 and first[:, 1].max() <= 1.2


@pytest.mark.parametrize(("keys", "distribution"), [
    ({"kind": "uniform", "low": 2.0, "high": 3.0}, stats.uniform(2.0, 1.0)),
    ({"kind": "normal", "mean": 4.0, "deviation": 0.5}, stats.norm(4.0, 0.5)),
    ({"kind": "log-uniform", "low": 0.1, "high": 10.0}, stats.loguniform(0.1, 10.0))])
def test_distributions_are_those_of_scipy(keys: dict[str, object], distribution: stats.rv_continuous) -> None:
    study = tiny(vary=[{"set": MASS, **keys}], design={"kind": "sobol", "samples": 256})
    found = samples(study)[:, 0]
    assert found == pytest.approx(distribution.ppf(unit_samples(study)[:, 0]), rel=1e-12)
    assert stats.kstest(found, distribution.cdf).pvalue > 0.5


def test_correlated_samples_have_the_covariance() -> None:
    covariance = [[0.04, 0.018], [0.018, 0.09]]
    study = tiny(vary=[{"set": name, "kind": "normal", "mean": mean} for name, mean in ((MASS, 4.0), (FRICTION, 3.0))],
                 correlated=[{"of": [MASS, FRICTION], "covariance": covariance}],
                 design={"kind": "sobol", "samples": 4096})
    found = samples(study)
    assert found.mean(axis=0) == pytest.approx([4.0, 3.0], abs=1e-3)
    assert np.cov(found.T) == pytest.approx(np.array(covariance), rel=0.02, abs=1e-3)


def test_a_matrix_that_is_no_covariance_is_refused() -> None:
    study = tiny(vary=[{"set": name, "kind": "normal", "mean": 4.0} for name in (MASS, FRICTION)],
                 correlated=[{"of": [MASS, FRICTION], "covariance": [[1.0, 2.0], [2.0, 1.0]]}],
                 design={"kind": "sobol", "samples": 4})
    with raises(ScenarioError, "positive definite"):
        samples(study)


@given(varied=st.integers(1, 5), power=st.integers(0, 4))
def test_saltelli_changes_one_column_at_a_time(varied: int, power: int) -> None:
    vary = [{"set": f"plant.p{i}", "kind": "uniform", "low": 0, "high": 1} for i in range(varied)]
    points = unit_samples(tiny(vary=vary, design={"kind": "saltelli", "samples": 2**power}))
    for block in points.reshape(2**power, varied + 2, varied):
        for column in range(varied):
            changed = block[column + 1] != block[0]
            assert changed.tolist() == [i == column for i in range(varied)]
            assert block[column + 1, column] == block[-1, column]


@pytest.mark.parametrize(("table", "facts"), [
    ({"vary": []}, ["vary", "[]"]),
    ({"vary": [{"set": MASS, "kind": "grid", "from": 1, "to": 2}]}, ["vary[0].number", "missing"]),
    ({"vary": [{"set": MASS, "kind": "gird", "values": [1]}]}, ["vary[0].kind", "'gird'", "'grid'"]),
    ({"vary": [{"set": MASS, "kind": "list", "values": [1], "low": 2}]}, ["vary[0].low", "2", "kind"]),
    ({"vary": [{"set": MASS, "kind": "uniform", "low": 2, "high": 1}], "design": {"kind": "sobol", "samples": 2}},
     ["vary[0].high", "1", "low", "2"]),
    ({"vary": [{"set": MASS, "kind": "uniform", "low": 1, "high": 2}]}, ["vary[0].kind", "'uniform'", "grid"]),
    ({"vary": [{"set": MASS, "kind": "log-uniform", "low": 0, "high": 2}]}, ["vary[0].low", "0", "more than 0"]),
    ({"vary": [{"set": MASS, "kind": "normal", "mean": 1}], "design": {"kind": "sobol", "samples": 2}},
     ["vary[0].deviation", "missing"]),
    ({"vary": [{"set": MASS, "kind": "normal", "mean": 1}],
      "correlated": [{"of": [MASS + "s", MASS], "covariance": [[1.0, 0.0], [0.0, 1.0]]}]},
     ["correlated[0].of", f"'{MASS}s'", "'normal'", f"'{MASS}'"]),
    ({"vary": 2 * [{"set": MASS, "kind": "list", "values": [1]}]}, [f"'{MASS}'", "another name"]),
    ({"design": {"kind": "sobol", "samples": 3}}, ["design.samples", "3", "power of 2"]),
    ({"design": {"kind": "halton"}}, ["design.samples", "missing"]),
    ({"design": {"samples": 3}}, ["design.samples", "3"]),
    ({"limits": {"overshoot": {}}}, ["limits.overshoot.max", "max or min"]),
    ({"limits": {"overshoot": {"min": 0.3, "max": "20 %"}}}, ["limits.overshoot.max", "'20 %'", "0.3"]),
    ({"colour": "red"}, ["colour", "'red'"])])
def test_bad_files_are_refused_in_one_line(table: dict[str, object], facts: list[str]) -> None:
    with raises(ScenarioError, "study.toml", *facts):
        tiny(**table)


@pytest.mark.parametrize(("values", "different"), [({"kind": "list", "values": [4, "5 kg", 5.0]}, 2),
                                                   ({"kind": "grid", "from": 4, "to": 4, "number": 3}, 1)])
def test_a_value_is_once_in_a_grid(values: dict[str, object], different: int) -> None:
    """Its samples would be the same, and have one cell of a map, and one place of an array."""
    with raises(ScenarioError, MASS, "3 values", different):
        samples(tiny(vary=[{"set": MASS, **values}]))
    drawn = samples(tiny(vary=[{"set": MASS, **values}], design={"kind": "latin hypercube", "samples": 3}))
    assert samples(tiny(vary=[{"set": MASS, **values}], design={"kind": "rows"})).tolist() == sorted(drawn.tolist())


def test_too_many_samples_are_refused() -> None:
    vary = [{"set": f"plant.p{i}", "kind": "grid", "from": 0, "to": 1, "number": 200} for i in range(3)]
    with raises(ScenarioError, "design", "8e+06", "1e+06"):
        samples(tiny(vary=vary))


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.toml")), ids=lambda path: path.stem)
def test_studies_of_the_package_are_named_after_their_files(path: Path) -> None:
    assert load_study(path.stem)[0].name == path.stem
