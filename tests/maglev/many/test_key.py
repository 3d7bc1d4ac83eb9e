"""A stored sample is known by all that its run is made of: whatever changes a run changes the key."""

import copy
from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tiny_study import SCENARIO

from maglev.files.errors import MaglevError
from maglev.many.sample_key import LEFT_OUT, canonical, study_key
from maglev.many.samples import Job
from maglev.many.study_columns import columns_of, named_values
from maglev.many.study_design import Target
from maglev.runs.measuring import run_metrics
from maglev.runs.metrics import phase_resistances
from maglev.runs.preparation import Experiment, prepare
from maglev.scenario.catalogue import build
from maglev.scenario.layers import merged, run_layers
from maglev.scenario.loading import load_plan
from maglev.scenario.run_plan import RunPlan
from maglev.user.source import FmuFile

MORE = """
[[signals]]
to = "plant.v.force"
kind = "csv"
file = "push.csv"
column = "force"

[[signals]]
to = "plant.h.force"
kind = "sinusoids"
ramp = "0.1 s"
terms = [{ amplitude = "1 N", omega = "60 rad/s" }, { amplitude = "2 N", omega = "90 rad/s", phase = "0.5 rad" }]

[metrics]
tracking_from = "0.06 s"

[[events]]
name = "push"
time = "0.06 s"
end = "0.1 s"

[[events]]
name = "another push"
time = "0.12 s"

[[claims]]
text = "It is quick"
source = "here"
metric = "settling_time"
axis = "v"
band = "10 um"
relation = "<"
target = "20 ms"

[fmus.controller.start]
antiwindup = true
"""

PUSH = "time,force\n0,0\n0.07,1\n0.08,0\n"

Keys = tuple[str | int, ...]


@pytest.fixture(scope="module")
def two_fmus(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("two_fmus")
    build(["Plant2DOF", "Regulator2DOF", "PID2DOF"], folder)
    return folder


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The scenario, with all that it extends, as one table."""
    folder = tmp_path_factory.mktemp("rich")
    (folder / "push.csv").write_text(PUSH, encoding="utf-8")
    (folder / "rich.toml").write_text(SCENARIO + MORE, encoding="utf-8")
    layers, = run_layers(folder / "rich.toml")
    return merged(layers)


def places(value: Any, keys: Keys = ()) -> Iterator[Keys]:
    """Where something stands in a table."""
    for key, entry in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
        yield (*keys, key)
        yield from places(entry, (*keys, key))


def others(value: Any, words: list[str]) -> Iterator[Any]:
    """Values instead of one: of its kind, or less of it, or in another order; also nothing at all, `...`."""
    if isinstance(value, bool):
        yield not value
    elif isinstance(value, (int, float)):
        yield from (value + 1, 2 * value, value / 2, 0)
    elif isinstance(value, str):
        number, blank, unit = value.partition(" ")
        if blank and unit.isalpha() and number.replace(".", "", 1).replace("-", "", 1).isdigit():
            yield from (f"{2 * float(number)} {unit}", f"{float(number) / 2} {unit}")
        else:
            yield from (f"{value}x", *words)
    elif isinstance(value, list):
        yield from (value[::-1], value[1:], value[:-1], [*value[1:], *value[:1]])
    elif isinstance(value, dict):
        yield dict(reversed(value.items()))
    yield ...


def changed(table: dict[str, Any], keys: Keys, value: Any) -> dict[str, Any]:
    """The table with another value at a place."""
    found = copy.deepcopy(table)
    entry: Any = found
    for key in keys[:-1]:
        entry = entry[key]
    if value is ...:
        del entry[keys[-1]]
    else:
        entry[keys[-1]] = value
    return found


def experiment(table: dict[str, Any], fmus: Path) -> Experiment | None:
    """The table made ready; None of one that is refused."""
    try:
        made = prepare(RunPlan.model_validate(table), fmus, {}, {})
        made.check()
        trial(made)
    except (MaglevError, ValueError):
        return None
    return made


def trial(made: Experiment) -> list[Any]:
    """All that the master is given, and what is measured on a recording that has something of everything."""
    plan, descriptions = made.plan, made.check()
    times, drives = made.times, made.drives(descriptions)
    random = np.random.default_rng(1)
    names = {*made.outputs(), *drives, *(flag for flag in (plan.stop_flag, plan.trip_flag) if flag)}
    columns = {name: drives[name] if name in drives else random.normal(0.02, 1e-3, len(times))
               for name in sorted(names)}
    for flag in (plan.stop_flag, plan.trip_flag):
        if flag is not None:
            columns[flag] = np.where(times > 0.15, 1.0, 0.0)
    measured = named_values(plan, run_metrics(plan, times, columns, phase_resistances(plan)({})))
    return [[(setup.name, [sha256 for _, sha256 in setup.source.digests()], sorted(setup.start.items()))
             for setup in made.setups()], sorted(made.connections), made.step, made.order, plan.stop_time,
            {name: values.tobytes() for name, values in sorted(drives.items())},
            {name: repr(value) for name, value in sorted(measured.items())}]


def key(made: Experiment, values: Any = ((4.0,), (5.0,))) -> str:
    targets = (Target("plant.v.mass", 0, "value", 4.0, "kg", False, 0.0, 10.0),)
    plan = made.plan
    time = made.times
    rest = {name: np.zeros(len(time)) for motor in plan.motors.values() for name in (*motor.currents, *motor.commands)}
    rest |= {flag: np.zeros(len(time)) for flag in (plan.stop_flag, plan.trip_flag) if flag}
    for axis in plan.axes.values():
        rest[axis.position] = rest[axis.reference] = np.zeros(len(time))
    columns = columns_of(named_values(plan, run_metrics(plan, time, rest)), None, {}, "here")
    return study_key(Job("", "code", made, targets, tuple(columns)), np.array(values))


def mutants(table: dict[str, Any]) -> list[tuple[Keys, Any]]:
    """Every change of one thing in a table."""
    words = ["plant.v.position", "plant.v.force", "controller.h.reference", "PID2DOF", "steps", "another"]
    found = []
    for keys in places(table):
        entry: Any = table
        for each in keys:
            entry = entry[each]
        found += [(keys, value) for value in others(entry, words)]
    return found


FOR_READERS = {("title",), ("description",), ("figures",), ("check_only",), ("another_reading",)}


def for_readers(keys: Keys) -> bool:
    """Whether what stands at a place of the file is for readers alone, or judged elsewhere than in studies."""
    return keys[:1] in FOR_READERS or keys[0] in ("claims", "check", "procedure")


@pytest.mark.thorough
def test_whatever_changes_a_run_changes_the_key(table: dict[str, Any], two_fmus: Path) -> None:
    """Each value of a rich scenario changed, dropped or put in another place: of some hundred that can be run."""
    base = experiment(table, two_fmus)
    assert base is not None
    simulated, tried, moved = trial(base), 0, 0
    seen = {key(base): simulated}
    for keys, value in mutants(table):
        made = experiment(changed(table, keys, value), two_fmus)
        if made is None:
            continue
        tried += 1
        now, known = trial(made), key(made)
        moved += now != simulated
        assert seen.setdefault(known, now) == now, (keys, value)
        if for_readers(keys):
            assert known == key(base), (keys, value)
    assert tried > 150 and moved > 100   # it was no empty exercise


@settings(suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow], max_examples=30)
@given(data=st.data())
def test_two_changes_at_once(table: dict[str, Any], two_fmus: Path, data: st.DataObject) -> None:
    """Also where two changes might undo each other."""
    once = changed(table, *data.draw(st.sampled_from(mutants(table))))
    twice = changed(once, *data.draw(st.sampled_from(mutants(once))))
    made = [each for each in (experiment(each, two_fmus) for each in (table, once, twice)) if each is not None]
    for one, other in combinations(made, 2):
        assert trial(one) == trial(other) or key(one) != key(other)


def test_of_each_attribute_but_those_that_are_listed(table: dict[str, Any], two_fmus: Path) -> None:
    """What is added to a plan, an experiment or a job is in the key for as long as nobody takes it out."""
    base = experiment(table, two_fmus)
    assert base is not None
    said = canonical(base)
    assert said[0] == "Experiment"
    assert {name for name, _ in said[1]} == {"plan", "step", "order", "ports", "timeout", "following"}
    plan = dict(said[1])["plan"]
    assert {name for name, _ in plan[1]} == set(RunPlan.model_fields) - LEFT_OUT[RunPlan]


def test_files_behind_a_plan_count_by_their_content(table: dict[str, Any], two_fmus: Path, tmp_path: Path) -> None:
    base = experiment(table, two_fmus)
    assert base is not None
    column = next(signal for signal in table["signals"] if signal["kind"] == "csv")
    place = table["signals"].index(column)
    same, other = tmp_path / "same.csv", tmp_path / "other.csv"
    same.write_text(PUSH, encoding="utf-8")
    other.write_text(PUSH.replace("0.07,1", "0.07,2"), encoding="utf-8")
    for path, equal in ((same, True), (other, False)):
        made = experiment(changed(table, ("signals", place, "file"), str(path)), two_fmus)
        assert made is not None
        assert (key(made) == key(base)) == equal
    other_plant = tmp_path / "Plant2DOF.fmu"
    other_plant.write_bytes((two_fmus / "Plant2DOF.fmu").read_bytes() + b"\0")
    assert key(replace(base, sources={**base.sources, "plant": FmuFile(other_plant)})) != key(base)
    assert key(base, ((4.0,), (5.5,))) != key(base)


def test_the_cases_that_gave_another_runs_numbers(tmp_path: Path, two_fmus: Path) -> None:
    """An event that got an end; two FMUs without start values in another order."""
    texts = {"plain": "", "event": '[[events]]\nname = "push"\ntime = "0.1 s"\n',
             "ended": '[[events]]\nname = "push"\ntime = "0.1 s"\nend = "0.15 s"\n',
             "order": '[fmus.plant]\nbefore = "controller"\n'}
    keys = {}
    for name, more in texts.items():
        path = tmp_path / "tiny.toml"
        path.write_text(f"{SCENARIO}\n{more}", encoding="utf-8")
        plan = load_plan(path)
        keys[name] = key(prepare(plan, two_fmus, {}, {}))
        without = {each: fmu.model_copy(update={"start": {}, "before": None}) for each, fmu in plan.fmus.items()}
        keys[f"{name}, no start values"] = key(prepare(plan.model_copy(update={"fmus": without}), two_fmus, {}, {}))
    assert len(set(keys.values())) == len(keys)
