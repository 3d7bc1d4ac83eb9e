from types import SimpleNamespace

import pytest
from facts import raises, require_facts

import maglev
from maglev.files.errors import ScenarioError, StageError
from maglev.runs.plan_check import check_names
from maglev.scenario.loading import load_plan
from maglev.scenario.signals import Steps

LOOP = """
step = "0.5 ms"
connections = [["plant.y.encoder", "controller.y.measured"], ["controller.m.i_a_cmd", "plant.m.i_a_cmd"]]
[fmus.controller]
model = "Regulator"
start = { antiwindup = false, order = 2 }
[fmus.plant]
file = "plant.fmu"
[axes.y]
position = "plant.y.position"
reference = "controller.y.reference"
[metrics]
bands = ["0.1 mm", "10 um"]
"""

EXPERIMENT = """
extends = "loops/loop.toml"
name = "hold"
title = "Hold"
stop_time = "2 s"
[fmus.controller.start]
antiwindup = true
[fmus.plant.start]
"y.position_start" = "25 mm"
[[signals]]
to = "controller.y.reference"
kind = "steps"
times = [0, 1]
values = ["25 mm", "27 mm"]
[[claims]]
text = "It settles"
source = "p. 1"
metric = "settling_time"
axis = "y"
band = "10 um"
relation = "<"
target = "5 s"
"""


@pytest.fixture
def write(tmp_path):
    """Write the loop and an experiment, with replacements in both."""
    def written(*replacements):
        loop, experiment = LOOP, EXPERIMENT
        for old, new in replacements:
            assert (loop + experiment).count(old) == 1
            loop, experiment = loop.replace(old, new), experiment.replace(old, new)
        (tmp_path / "loops").mkdir(exist_ok=True)
        (tmp_path / "loops" / "loop.toml").write_text(loop, encoding="utf-8")
        (tmp_path / "hold.toml").write_text(experiment, encoding="utf-8")
        return tmp_path / "hold.toml"
    return written


def refusal(path):
    with raises(ScenarioError) as caught:
        load_plan(path)
    return str(caught.value)


def test_extending_merges_deeply(write):
    path = write()
    plan = load_plan(path)
    assert list(plan.fmus) == ["controller", "plant"]
    assert {name: start.value for name, start in plan.fmus["controller"].start.items()} == {
        "antiwindup": True, "order": 2}
    assert plan.fmus["plant"].start["y.position_start"].value == 0.025
    assert plan.fmus["plant"].file == str(path.parent / "loops" / "plant.fmu")
    assert plan.metrics.bands == [1e-4, 1e-5]
    assert (plan.output_interval, plan.step, plan.steps) == (0.0005, 0.0005, 4000)
    assert plan.signals[0].value(1.0) == 0.027
    assert plan.source == path


def test_lists_are_replaced(write):
    path = write(("stop_time = \"2 s\"", "stop_time = \"2 s\"\nconnections = []"))
    assert load_plan(path).connections == []


def test_finds_a_csv_next_to_its_scenario(write):
    path = write(("kind = \"steps\"\ntimes = [0, 1]\nvalues = [\"25 mm\", \"27 mm\"]",
                  "kind = \"csv\"\nfile = \"gap.csv\"\ncolumn = \"gap\"\nunit = \"mm\""))
    (path.parent / "gap.csv").write_text("time,gap\n0,25\n")
    assert load_plan(path).signals[0].value(1.0) == 0.025


@pytest.mark.parametrize(("old", "new", "facts"), [
    ('stop_time = "2 s"', "", ["hold.toml", "stop_time", "required"]),
    ('stop_time = "2 s"', 'fail_error = "2 s"', ["fail_error = '2 s'", "[metrics]"]),
    ('stop_time = "2 s"', 'stop_time = true', ["stop_time = True", "not a quantity"]),
    ('stop_time = "2 s"', "stop_time = -2", ["hold.toml", "stop_time = -2.0", "greater than 0"]),
    ('stop_time = "2 s"', "stop_time = 2.0002", ["hold.toml", "stop_time = 2.0002", "whole number of communication"]),
    ('stop_time = "2 s"', "stop_time = 2\noutput_interval = 0.0007", ["hold.toml", "output_interval", "whole number"]),
    ('name = "hold"', "name = 3", ["hold.toml", "name = 3", "expected a valid string"]),
    ("bands =", "band =", ["loop.toml", "metrics.band = ", "'bands'"]),
    ('"10 um"]', '"10 kg"]', ["loop.toml", "metrics.bands[1] = '10 kg'", "in m"]),
    ('model = "Regulator"', "", ["fmus.controller", "model", "file"]),
    ("order = 2", 'order = "fast"', ["loop.toml", "fmus.controller.start.order = 'fast'", "25 mm"]),
    ('["25 mm", "27', '["25 mn", "27', ["hold.toml", "signals[0].values[0] = '25 mn'", "'mn'"]),
    ("antiwindup = true", 'limit = "4 AA"', ["hold.toml", "fmus.controller.start.limit = '4 AA'", "'AA'"]),
    ('"plant.m.i_a_cmd"]]', '"plant.m.i_a_cmd", "x"]]', ["loop.toml", "connections[1]", "at most 2"]),
    ('kind = "steps"', 'kind = "stpes"', ["hold.toml", "signals[0].kind = 'stpes'", "'steps'"]),
    ('kind = "steps"', "", ["hold.toml", "signals[0].kind", "expected the kind"]),
    ("times = [0, 1]", "ports = [0, 1]", ["signals[0].ports", "'to', 'rate_to', 'unit' and 3 others"]),
    ("times = [0, 1]", "tims = [0, 1]", ["hold.toml", "signals[0].tims = [0, 1]", "'times'"]),
    ("times = [0, 1]", "times = [1, 0]", ["hold.toml", "signals[0].times[1] = 0.0", "ascending"]),
    ("times = [0, 1]", "times = [0]", ["hold.toml", "signals[0].values = [0.025, 0.027]", "as many as times"]),
    ('"27 mm"', '"27 kg"', ["hold.toml", "signals[0].values[1] = '27 kg'", "in m"]),
    ('metric = "settling_time"', 'metric = "setling_time"',
     ["hold.toml", "claims[0].metric = 'setling_time'", "'settling_time'"]),
    ('axis = "y"', 'axis = "yy"', ["hold.toml", "claims[0].axes = 'yy'", "'y'"]),
    ('band = "10 um"', 'band = "20 um"', ["hold.toml", "claims[0].band = 2e-05", "metrics.bands"]),
    ('relation = "<"', "", ["hold.toml", "claims[0].relation", "required"]),
    ('title = "', 'metrics = { bands = [-1e-4] }\ntitle = "',
     ["hold.toml", "metrics.bands[0] = -0.0001", "greater than 0"]),
    ('title = "', 'metrics.fail_error = -1\ntitle = "', ["hold.toml", "metrics.fail_error = -1.0", "greater than 0"]),
    ('title = "', 'metrics.tracking_from = "3 s"\ntitle = "',
     ["hold.toml", "metrics.tracking_from = 3.0", "2.0 s at most"]),
    ('title = "', 'check.signals = { "plant.y" = { absolute = -1 } }\ntitle = "',
     ["hold.toml", "check.signals.\"plant.y\".absolute = -1", "expected 0 or more"]),
    ('"loops/loop.toml"', '"hold.toml"', ["hold.toml", "extends", "itself"]),
    ('"loops/loop.toml"', '"2dof-setpoints"', ["extends = '2dof-setpoints'", "'2dof-setpoints.toml'"]),
    ('"loops/loop.toml"', '"loops/lop.toml"', ["extends = 'loops/lop.toml'", "'loops/loop.toml'"]),
    ('"loops/loop.toml"', "3", ["hold.toml", "extends = 3", "relative path"]),
    ('"Regulator"', '"law.fmu"', ["fmus.controller.model = 'law.fmu'", "of a path the key is file"])])
def test_refusals_are_one_line_with_file_key_value_and_expectation(write, old, new, facts):
    message = refusal(write((old, new)))
    require_facts(message, *facts)


def test_tracking_claim_needs_a_start_of_tracking(write):
    message = refusal(write(('metric = "settling_time"\naxis = "y"\nband = "10 um"\nrelation = "<"\ntarget = "5 s"',
                             'metric = "peak_tracking_error"\nrelation = "<"\ntarget = "1 mm"')))
    require_facts(message, "claims[0].metric", "'peak_tracking_error'", "metrics.tracking_from")


EVENTS = ('[[claims]]', '[[events]]\nname = "push"\ntime = "1 s"\n\n[[events]]\nname = "pull"\ntime = "1500 ms"\n'
                        'end = "1.75 s"\n\n[[claims]]')
AFTER_EVENT = ('metric = "settling_time"', 'metric = "recovery_time"\nevent = "pull"')


def test_events_have_windows_and_claims(write):
    plan = load_plan(write(EVENTS, AFTER_EVENT))
    assert plan.event_ends == [1.5, 1.75]
    assert plan.claims[0].criterion == "recovery time to 10 µm of y after pull < 5 s"
    of_roll = ('metric = "settling_time"\naxis = "y"\nband = "10 um"\nrelation = "<"\ntarget = "5 s"',
               'metric = "integral_absolute_error"\naxis = "roll"\nrelation = "<"\ntarget = "50 urad s"')
    claim = load_plan(write(ROLL, EVENTS, of_roll)).claims[0]
    assert (claim.target, claim.criterion) == (50e-6, "integral absolute error of roll < 50 µrad·s")


def test_windows_end_at_events_steps_and_jumps_of_what_is_no_reference(write):
    plan = load_plan(write(EVENTS, AFTER_EVENT))
    signals = [Steps.model_validate({"to": to, "kind": "steps", "times": times, "values": values}) for to, times, values
               in ((plan.axes["y"].reference, [0.0, 1.2, 3.0], [0.02, 0.03, 0.03]),   # the last one is no step
                   ("plant.y.force", [0.0, 1.6, 1.7], [0.0, 5.0, 0.0]))]
    plan = plan.model_copy(update={"signals": signals})
    assert plan.event_ends == [1.2, 1.75]
    assert plan.disturbances == [(1.0, "push"), (1.5, "pull"), (1.6, "plant.y.force"), (1.7, "plant.y.force")]


@pytest.mark.parametrize(("changes", "facts"), [
    ([('"pull"', '"push"')], ["events[1].name = 'push'", "another name"]),
    ([('"1500 ms"', '"1 s"')], ["events[1].time = 1.0", "ascending", "push"]),
    ([('"1500 ms"', '"900 s"')], ["events[1].time = 900.0", "before stop_time"]),
    ([('"1.75 s"', '"1500 ms"')], ["events[1].end = 1.5", "after 1.5 s"]),
    ([('event = "pull"', 'event = "pul"')], ["claims[0].event = 'pul'", "'pull'"])])
def test_events_that_cannot_be_measured_are_refused(write, changes, facts):
    path = write(EVENTS, AFTER_EVENT)
    text = path.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    path.write_text(text)
    message = refusal(path)
    require_facts(message, *facts)


def test_a_claim_about_an_event_needs_one(write):
    message = refusal(write(('metric = "settling_time"', 'metric = "recovery_time"')))
    require_facts(message, "claims[0].metric", "'recovery_time'", "[[events]]")


def test_a_stage_in_place_of_a_scenario_and_the_other_way_round(tmp_path):
    path = tmp_path / "mine.toml"
    for text, *facts in (("stage = 3", "stage = 3", '"NAME.toml"'), ("[catalogue]", 'stage = "mine.toml"'),
                         ("[stage]\nattraction = 3", 'stage = "mine.toml"')):
        path.write_text(text)
        require_facts(refusal(path), path, *facts)
    path.write_text('stage = "other.toml"')
    with raises(StageError, "3dof"):
        maglev.stage("3dof")


def test_missing_path(tmp_path):
    require_facts(refusal(tmp_path / "none.toml"), tmp_path / "none.toml")


def variables(**kinds):
    found = {}
    for kind, names in kinds.items():
        for name in names.split():
            unit = "A" if ".i_" in name else "m" if name.startswith("y.") else None
            found[name] = SimpleNamespace(name=name, causality=kind, type="Real", unit=unit, initial=None)
    return found


@pytest.fixture
def descriptions():
    controller = variables(input="y.measured y.reference y.reference_rate", output="m.i_a_cmd y.error",
                           parameter="antiwindup order")
    controller["antiwindup"].type = "Boolean"
    controller["order"].type = "Integer"
    plant = variables(input="m.i_a_cmd y.force", output="y.encoder y.position at_stop", parameter="y.position_start")
    plant["at_stop"].type = "Boolean"
    return {"controller": controller, "plant": plant}


def check(path, descriptions):
    check_names(load_plan(path), descriptions, {})


def test_names_that_fit_pass(write, descriptions):
    check(write(("step = ", 'stop_flag = "plant.at_stop"\nstep = ')), descriptions)


@pytest.mark.parametrize(("old", "new", "facts"), [
    ('"controller.y.measured"', '"controller.y.measurd"', ["connections[0][1] = 'controller.y.measurd'",
      "'y.measured'"]),
    ('"controller.y.measured"', '"controler.y.measured"', ["'controler'", "'controller'"]),
    ('"controller.y.measured"', '"controller.y.error"', ["'y.error'", "output", "input"]),
    ('"plant.y.encoder"', '"plant.m.i_a_cmd"', ["connections[0][0]", "input", "output"]),
    ('"plant.y.encoder"', '"plant.at_stop"', ["connections[0]", "Boolean", "Real"]),
    ('"plant.y.encoder"', '"controller.m.i_a_cmd"', ["connections[0]", "A", "m"]),
    ('"controller.m.i_a_cmd", "plant.m.i_a_cmd"', '"plant.y.encoder", "controller.y.measured"',
     ["connections[1][1]", "connections[0][1]"]),
    ('to = "controller.y.reference"', 'to = "controller.y.measured"', ["signals[0].to", "connections[0][1]"]),
    ('to = "controller.y.reference"', 'to = "plant.y.forc"', ["signals[0].to", "'y.force'"]),
    ('kind = "steps"', 'kind = "steps"\nrate_to = "controller.y.refrate"', ["signals[0].rate_to", "y.reference_rate"]),
    ('"27 mm"', '27, "28 mm"', ["signals[0].values", "as many"]),
    ('values = ["25 mm", "27 mm"]', 'values = ["1 A", "2 A"]', ["signals[0].to", "A", "m"]),
    ('"y.position_start"', '"y.position_stat"', ['fmus.plant.start."y.position_stat"', "'y.position_start'"]),
    ('"y.position_start" = "25 mm"', '"y.position_start" = "2 kg"', ["= '2 kg'", "kg", "m"]),
    ('"y.position_start" = "25 mm"', '"y.position_start" = true', ["= True", "Real"]),
    ('"y.position_start"', '"y.position"', ['fmus.plant.start."y.position"', "output", "parameter", "input"]),
    ("antiwindup = true", "antiwindup = 1", ["fmus.controller.start.antiwindup = 1", "Boolean", "true", "false"]),
    ("order = 2", "order = 2.5", ["fmus.controller.start.order = 2.5", "Integer"]),
    ('position = "plant.y.position"', 'position = "plant.y.positon"', ["axes.y.position", "'y.position'"]),
    ('position = "plant.y.position"', 'position = "plant.at_stop"', ["axes.y.position", "Real"]),
    ("step = ", 'trip_flag = "plant.y.encoder"\nstep = ', ["trip_flag", "Boolean"]),
    ("[metrics]", '[motors.m]\ncurrents = ["plant.m.i_a"]\n[metrics]', ["motors.m.currents[0]", "plant.m.i_a"])])
def test_names_that_do_not_fit_are_refused(write, descriptions, old, new, facts):
    path = write((old, new))
    with raises(ScenarioError, "hold.toml", *facts):
        check(path, descriptions)


def test_start_value_with_a_unit_is_refused_where_the_fmu_is_not_si(write, descriptions):
    descriptions["plant"]["y.position_start"].unit = "mm"
    with raises(ScenarioError, "hold.toml", "mm"):
        check(write(), descriptions)


ROLL = ('reference = "controller.y.reference"\n', """reference = "controller.y.reference"
[axes.roll]
position = "plant.roll.position"
reference = "controller.roll.reference"
rotation = true
""")
TILT_BANDS = ('bands = ["0.1 mm", "10 um"]', 'bands = ["0.1 mm", "10 um"]\ntilt_bands = ["0.1 mrad"]')


def test_claims_about_rotations_are_in_rad(write):
    about_roll = ('axis = "y"\nband = "10 um"', 'axis = "roll"\nband = "0.1 mrad"')
    plan = load_plan(write(ROLL, TILT_BANDS, about_roll))
    assert plan.claims[0].criterion == "settling time to 0.1 mrad of roll < 5 s"
    of_error = ('metric = "settling_time"\naxis = "y"\nband = "10 um"\nrelation = "<"\ntarget = "5 s"',
                'metric = "steady_state_error"\naxis = "roll"\nrelation = "<"\ntarget = "50 urad"')
    claim = load_plan(write(ROLL, of_error)).claims[0]
    assert (claim.target, claim.criterion) == (50e-6, "steady-state error of roll < 50 µrad")


@pytest.mark.parametrize(("changes", "facts"), [
    ([('axis = "y"\nband = "10 um"', 'band = "10 um"')], ["claims[0].axes", "roll", "rad", "m"]),
    ([('axis = "y"', 'axis = "roll"')], ["claims[0].axes", "roll", "rad"]),
    ([('"10 um"\nrelation', '"0.1 mrad"\nrelation')], ["claims[0].axes", "y", "m", "rad"]),
    ([('axis = "y"\nband = "10 um"', 'axis = "roll"\nband = "1 mrad"')],
     ["claims[0].band = 0.001", "metrics.tilt_bands"]),
])
def test_a_claim_that_mixes_lengths_and_angles_is_refused(write, changes, facts):
    message = refusal(write(ROLL, TILT_BANDS, *changes))
    require_facts(message, *facts)
