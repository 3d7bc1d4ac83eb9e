"""What is refused before the first run."""

import shutil
from collections import namedtuple
from pathlib import Path

import numpy as np
import pytest
from facts import raises
from tiny_study import UNCHANGED, planned, scenario, tiny

import maglev
from maglev.api import studying
from maglev.files.errors import ScenarioError
from maglev.many.dataset import samples_schema
from maglev.many.study_design import require_free
from maglev.many.study_file import load_study
from maglev.many.study_plan import plan_study
from maglev.runs.preparation import prepare
from maglev.scenario.loading import load_plan
from maglev.scenario.settings import start_values

Usage = namedtuple("Usage", "total used free")


def varied(**keys: object) -> dict[str, object]:
    return {"vary": [{"kind": "list", "values": [1.0], **keys}]}


def sampled(**design: object) -> dict[str, object]:
    """A Latin hypercube of masses."""
    return {"vary": [{"set": "plant.v.mass", "kind": "uniform", "low": 4.0, "high": 5.0}],
            "design": {"kind": "latin hypercube", **design}}


@pytest.mark.parametrize(("table", "facts"), [
    (varied(set="plant.v.mas"), ["plant", "'v.mas'", "'v.mass'"]),
    (varied(set="plan.v.mass"), ["'plan'", "'plant'"]),
    (varied(set="plant.v.position"), ["plant.v.position", "output", "parameter", "input"]),
    (varied(set="controller.v.measured"), ["controller.v.measured", "parameter"]),
    (varied(set="plant.h.position_start", mode="factor"), ["plant.h.position_start", "factor", "0"]),
    (varied(set="reference.v.ende"), ["reference.v.ende", "'end'"]),
    (varied(set="plant.v.mass", values=["4 N"]), ["4 N", "kg"]),
    (varied(set="plant.v.mass", values=["4 kg"], mode="factor"), ["4 kg", "factor"]),
    (varied(set="plant.v.mass", values=[True]), ["plant.v.mass", "True", "number"]),
    (varied(set="controller.antiwindup", values=[1.0]), ["controller.antiwindup", "Boolean", "true", "false"]),
    ({"vary": [{"set": "controller.antiwindup", "kind": "grid", "from": False, "to": True, "number": 3}]},
     ["controller.antiwindup", "Boolean", "between false and true"]),
    (varied(set="plant.v.mass", values=[4.0, -1.0, -2.0]), ["plant.v.mass", "2 of 3", "-1", "0.001", "1e+06 kg"]),
    ({"metrics": ["overshot of v"]}, ["'overshot of v'", "'overshoot of v'"]),
    ({"limits": {"overshoot of v": {"max": "2 s"}}}, ["limits.overshoot of v", "'2 s'", "1"]),
    ({"keep": ["plant.v.positio"]}, ["plant.v.positio", "'plant.v.position'"]),
    ({"keep": ["plant.v.position", "plant.h.position", "plant.v.position"]},
     ["keep[2]", "'plant.v.position'", "twice"]),
    ({"keep_interval": "0.7 ms"}, ["keep_interval", "0.0007 s", "0.0005 s"]),
    ({"keep_interval": "0.1 ms"}, ["keep_interval", "0.0001 s", "0.0005 s"]),
    ({"keep_interval": 1e308}, ["keep_interval", "1e+308 s"]), ({"keep_interval": "1 s"}, ["keep_interval", "0.2 s"]),
    ({"sample_timeout": 1e300}, ["sample_timeout", "1e+300 s", "1e+06 s"]),
    ({"limits": {"overshoot": {"min": "50 %", "max": "20 %"}}}, ["limits.overshoot.max", "'20 %'", "50 %"]),
    ({"limits": {"overshoot": {"min": "50 %"}, "overshoot of h": {"max": 0.1}}},
     ["limits.overshoot of h", "0.5", "0.1"]),
    (sampled(samples=True), ["design.samples", "True", "integer"]),
    (sampled(samples="3"), ["design.samples", "'3'", "integer"]),
    (sampled(samples=3, seed="1"), ["design.seed", "'1'", "integer"]),
    ({"vary": [{"set": "plant.v.mass", "kind": "grid", "from": 4, "to": 5, "number": True}]},
     ["vary[0].number", "True", "integer"])])
def test_refused(table: dict[str, object], facts: list[str], fastest_fmus: Path, tmp_path: Path) -> None:
    with raises(ScenarioError, "study.toml", *facts):
        planned(tmp_path, fastest_fmus, **table)


def test_a_study_that_does_not_fit_on_the_disk_is_refused(fastest_fmus: Path, tmp_path: Path,
                                                          monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda _path: Usage(0, 0, 1e8 + 1e5))
    planned(tmp_path, fastest_fmus)
    with raises(ScenarioError, "20 samples"):
        planned(tmp_path, fastest_fmus, keep=["plant.v.position"], keep_interval="0.5 ms")


def test_the_metrics_to_keep(fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus, metrics=["overshoot", "settling time to 10 um of v at t = 0.05 s"],
                    limits={"rms error of h": {"max": "1 mm"}})
    names = [column.name for column in study.job.columns]
    assert names[5:] == ["overshoot of v", "overshoot of h", "settling time to 10 µm of v at t = 0.05 s",
                         "rms error of h"]
    assert study.job.columns[-1].max == 1e-3


def test_factors_and_offsets_are_of_the_nominal_values(fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus, vary=[
        {"set": ["plant.v.mass", "plant.h.mass"], "name": "payload", "mode": "offset", "kind": "list", "values": [0.5]},
        {"set": "plant.h.friction.coulomb", "mode": "factor", "kind": "list", "values": [2]}])
    plain = planned(tmp_path, fastest_fmus).job.experiment.parameters()
    assert [plain["plant.v.mass"], plain["plant.h.mass"]] == [4.35, 1.594]
    assert 1.594 + 0.5 == 2.0940000000000003, "which nobody would write"
    assert study.values.tolist() == [[4.85, 2.094, 2 * plain["plant.h.friction.coulomb"]]]
    assert samples_schema(study).names[:4] == [
        "sample", "payload", "factor of plant.h.friction.coulomb", "plant.v.mass"]


@pytest.mark.parametrize("given", [{"plant.v.mass": 4.5}, {"plant.h.mass": "4 kg"}])
def test_what_varies_cannot_be_set_as_well(given: dict[str, str | float], tmp_path: Path) -> None:
    """Each run would overwrite it; what a factor is of can be set."""
    name, = given
    both = {"set": ["plant.v.mass", "plant.h.mass"], "kind": "list", "values": [1.0]}
    with raises(ScenarioError, "set", name):
        maglev.study(tiny(vary=[both], set=given), fmus=tmp_path)
    with raises(ScenarioError, name):
        maglev.study(scenario(tmp_path), vary={name: [4.0]}, set=given, fmus=tmp_path)
    require_free(start_values({name: 1}), tiny(vary=[{**both, "mode": "factor"}]).vary, "study.toml")


def test_what_varies_together_is_written_as_one_likes() -> None:
    study = studying.varied("2dof-setpoints", {"plant.v.mass, plant.h.mass ": "4, 5"}, None, (), None, 0)
    assert study.vary[0].set == ["plant.v.mass", "plant.h.mass"]


def test_values_may_be_of_numpy(tmp_path: Path) -> None:
    given = {"plant.v.mass": np.array([4, 5]), "plant.h.mass": np.array([1.5], np.float32), "plant.motor.amplifier.off":
             np.array([True])}
    study = studying.varied("2dof-setpoints", given, None, (), None, 0)
    assert [[value.value for value in entry.values or ()] for entry in study.vary] == [[4, 5], [1.5], [True]]
    for vary, keep, *facts in (({"plant.v.mass": None}, (), "vary[0].values", "'list'"),
                               ({"plant.v.mass": [4.0]}, "plant.v.force", "keep", "'plant.v.force'", "list")):
        with raises(ScenarioError, *facts):
            maglev.study(scenario(tmp_path), vary=vary, keep=keep)   # type: ignore[arg-type]


@pytest.mark.parametrize("stage", ["2dof", "3dof", "5dof"])
def test_the_operating_range_can_be_studied_with_every_law(stage: str, fastest_fmus: Path, tmp_path: Path) -> None:
    study, path = load_study(f"range-{stage}")
    scenarios = sorted((path.parent / study.scenario).parent.glob(f"{stage}-*.toml"))
    laws = [each for each in scenarios if each.stem != f"{stage}-horizontal"]
    assert len(laws) == {"2dof": 3, "3dof": 4, "5dof": 3}[stage]
    for law in laws:
        plan_study(study, prepare(load_plan(law), fastest_fmus, {}, {}), path.name, tmp_path, UNCHANGED)
