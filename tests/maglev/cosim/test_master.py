"""The master: the sampled loop bit for bit, third-party FMUs, and refusals that lose nothing."""

import math
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from facts import raises
from pythonfmu.builder import FmuBuilder
from sampled_loop import PHASES, sampled_loop

from maglev.cosim import Order
from maglev.cosim.master import FmuSetup, Master, RunFailed, RunInterrupted
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.errors import ControllerError, FmuError
from maglev.runs.preparation import prepare
from maglev.scenario.loading import load_plan

STAGE_3DOF = PACKAGED_STAGES["3dof"]


@pytest.mark.few(3)
@pytest.mark.parametrize("name", ["2dof-setpoints", "2dof-tracking-friction-compensation", "2dof-smooth-linear",
                                  "2dof-tracking-pid", "3dof-setpoints-improved", "3dof-smooth-linear",
                                  "3dof-tracking-pid",   # more of the same regulators:
                                  *(pytest.param(f"3dof-{name}", marks=pytest.mark.thorough)
                                    for name in ("setpoints", "smooth-scheduled", "tracking-nonlinear"))])
@pytest.mark.parametrize("order", ["sequential", "jacobi"])
@pytest.mark.usefixtures("slow")
def test_run_equals_direct_calls_bit_for_bit(request: pytest.FixtureRequest, name: str, order: Order) -> None:
    """1.1 s under every controller, the first step of the setpoints included; one order with each kind of FMU."""
    fmus: Path = request.getfixturevalue("fmus" if order == "sequential" else "fastest_fmus")
    plan = load_plan(name).model_copy(update={"stop_time": 1.1})
    experiment = prepare(plan, fmus, {}, {}, {"order": order})
    recording = experiment.run()
    drives = experiment.drives(experiment.check())
    names = [n for n in recording.columns if n not in drives]
    assert len(names) == len(list(recording.columns)) - len(drives)
    times = [k * plan.step for k in range(plan.steps)]
    direct = sampled_loop(plan, drives, names, times, [plan.step] * len(times), order)
    for n in names:
        assert np.array_equal(recording.columns[n].astype(float).view(np.int64), direct[n].view(np.int64)), n
    position = recording.columns[next(n for n in names if n.endswith(".position"))]
    assert np.ptp(position) > 1e-4, "something has to move for this to mean anything"


def three(fmus: Path) -> list[FmuSetup]:
    return [FmuSetup("controller", fmus / "Regulator3DOF.fmu"), FmuSetup("plant", fmus / "Plant3DOF.fmu"),
            FmuSetup("shadow", fmus / "Plant3DOF.fmu")]


def loop_connections(to: str = "plant") -> list[tuple[str, str]]:
    commands = [(f"controller.{m}.{p}", f"{to}.{m}.{p}") for m in STAGE_3DOF.motor_names for p in PHASES]
    return commands + ([(f"plant.{a}.encoder", f"controller.{a}.measured") for a in STAGE_3DOF.axis_names]
                       if to == "plant" else [])


def test_three_fmus_one_output_to_two_inputs(fmus: Path) -> None:
    with Master(three(fmus), [*loop_connections(), *loop_connections("shadow")], 2e-4) as master:
        columns = master.run(0.2).columns
    assert np.array_equal(columns["plant.y.position"], columns["shadow.y.position"])
    assert np.ptp(columns["plant.y.position"]) > 0.0


def test_shuffled_connections_give_the_same_run(fmus: Path) -> None:
    results = []
    for order in (1, -1):
        with Master(three(fmus)[:2], loop_connections()[::order], 2e-4) as master:
            results.append(master.run(0.1, {"controller.x.reference": [0.005] * 501}).columns)
    for name, column in results[0].items():
        assert np.array_equal(column, results[1][name]), name


def test_step_below_the_sample_time(fmus: Path) -> None:
    """At half the sample time the controller holds its commands over two communication steps."""
    with Master(three(fmus)[:2], loop_connections(), 1e-4) as master:
        columns = master.run(0.02, {"controller.x.reference": [0.005] * 201}).columns
    commands = columns["controller.alpha.i_q_cmd"][1:]
    assert np.array_equal(commands[0::2], commands[1::2])
    assert len(set(commands)) > 50


def test_a_second_run_is_that_of_new_fmus(fastest_fmus: Path) -> None:
    drives = {"controller.x.reference": [0.005] * 501}
    heavy = FmuSetup("plant", fastest_fmus / "Plant3DOF.fmu", {"y.mass": 7.5})
    with Master([three(fastest_fmus)[0], heavy], loop_connections(), 2e-4) as master:
        expected = master.run(0.1, drives).columns
    with Master(three(fastest_fmus)[:2], loop_connections(), 2e-4) as master:
        first = {name: values.copy() for name, values in master.run(0.1).columns.items()}
        master.wire(0.1, {"controller.x.reference": [0.0] * 501})
        trials = [first]
        for given, start in ((drives, {"plant": {"y.mass": 7.5}}), ({"controller.x.reference": [0.0] * 501}, {})):
            master.drive(given)
            trials.append({name: values.copy() for name, values in master.run_again(start).columns.items()})
    assert all(np.array_equal(trials[1][name], values) for name, values in expected.items())
    assert all(np.array_equal(trials[2][name], values) for name, values in first.items())
    assert not np.array_equal(first["plant.y.position"], expected["plant.y.position"])


def test_refused_step_keeps_the_recording(fmus: Path) -> None:
    reference = [0.0] * 100 + [math.nan] * 401
    with Master(three(fmus)[:2], loop_connections(), 2e-4) as master, \
            raises(RunFailed, "0.02 s", "x.reference", "nan m") as failure:
        master.run(0.1, {"controller.x.reference": reference})
    recording = failure.value.recording
    assert len(recording.time) == 101
    assert np.isfinite(recording.columns["plant.y.position"]).all()
    assert recording.columns["plant.y.position"][-1] != 0.0


def test_interrupted_step_keeps_the_recording(fmus: Path) -> None:
    """Between two reports of progress as well."""
    calls = 0

    def interrupt(*_: object) -> int:
        nonlocal calls
        calls += 1
        if calls == 124:
            raise KeyboardInterrupt
        return 0

    with Master(three(fmus)[:2], loop_connections(), 2e-4) as master:
        master.fmus["controller"].do_step = interrupt
        with raises(RunInterrupted, "0.0246 s") as failure:
            master.run(0.1)
    assert len(failure.value.recording.time) == 124
    assert failure.value.recording.columns["plant.y.position"][-1] != 0.0


@pytest.mark.parametrize(("connections", "drives", "facts"), [
    ([("plant.y.encoder", "controller.y.measurd")], {}, ["y.measurd", "'y.measured'"]),
    ([("plnt.y.encoder", "controller.y.measured")], {}, ["plnt", "controller", "plant"]),
    ([("plant.y.force", "controller.y.measured")], {}, ["plant.y.force", "input", "output"]),
    ([("plant.at_stop", "controller.y.measured")], {}, ["plant.at_stop", "controller.y.measured", "type"]),
    ([("plant.y.encoder", "controller.y.measured")] * 2, {}, ["controller.y.measured", "two sources"]),
    ([("plant.y.encoder", "controller.y.measured")], {"controller.y.measured": [0.0] * 6},
     ["controller.y.measured", "two sources"]),
    ([("plant.y.encoder",)], {}, ["('plant.y.encoder',)", "pair"]),
    ({"plant.y.encoder": "controller.y.measured"}, {}, ["'plant.y.encoder'", "pair"]),
    ([], {"controller.y.reference": 0.025}, ["controller.y.reference", "0.025", "6 numbers"]),
    ([], {"controller.y.reference": [[0.0], [0.0]]}, ["controller.y.reference", "6 numbers"]),
    ([], {"controller.y.reference": ["25 mm"] * 6}, ["controller.y.reference", "6 numbers"]),
    ([], {"controller.y.reference": [0.0] * 5}, ["controller.y.reference", "5 values", "6 numbers"])])
def test_wrong_wiring(fmus: Path, connections: Any, drives: dict[str, Any], facts: list[str]) -> None:
    with Master(three(fmus)[:2], connections, 2e-4) as master, raises(FmuError, *facts):
        master.run(0.001, drives)


@pytest.mark.parametrize(("start", "facts"), [
    ({"y.mas": 1.0}, ["y.mas", "'y.mass'"]), ({"y.mass": -1.0}, ["y.mass", "-1.0 kg", "0.001"]),
    ({"y.mass": "7.5 kg"}, ["plant.y.mass", "'7.5 kg'", "Real"]), ({"y.mass": True}, ["plant.y.mass", "True", "Real"])])
def test_wrong_start_value(fmus: Path, start: dict[str, Any], facts: list[str]) -> None:
    plant = FmuSetup("plant", fmus / "Plant3DOF.fmu", start)
    with Master([plant], [], 2e-4) as master, raises(FmuError, *facts):
        master.run(0.001)


TANK = """
from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real, String

class Tank(Fmi2Slave):
    def __init__(self, **options):
        super().__init__(**options)
        self.pumps, self.open, self.label, self.level = 1, True, "tank", 0.0
        kept = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.fixed}
        for variable in (Integer("pumps", **kept), Boolean("open", **kept), String("label", **kept),
                         Real("level", causality=Fmi2Causality.output)):
            self.register_variable(variable)

    def do_step(self, time, step):
        self.level += step * self.pumps * self.open
        return True
"""


def test_start_values_of_each_type_of_third_party_fmus(tmp_path: Path) -> None:
    (tmp_path / "tank.py").write_text(TANK, encoding="utf-8")
    path = FmuBuilder.build_FMU(tmp_path / "tank.py", dest=tmp_path)

    def level(start: dict[str, Any]) -> float:
        with Master([FmuSetup("tank", path, start)], [], 0.5) as master:
            return float(master.run(1.0).columns["tank.level"][-1])

    assert [level({"pumps": np.int64(2)}), level({"open": False}), level({"open": 1}), level({"label": "x"})] == [
        2.0, 0.0, 1.0, 1.0]
    for name, value, kind in ("pumps", 2.5, "Integer"), ("open", 2, "Boolean"), ("label", 3, "String"):
        with raises(FmuError, f"tank.{name}", value, kind):
            level({name: value})


def test_stop_time_that_is_no_whole_number_of_steps(fmus: Path) -> None:
    with Master(three(fmus)[:2], [], 2e-4) as master, raises(FmuError, "stop time", "0.0003 s", "0.0002 s"):
        master.run(0.0003)


@pytest.mark.parametrize("step", [0.0, -1e-4, math.nan, math.inf])
def test_step_that_is_not_positive(fmus: Path, step: float) -> None:
    with raises(FmuError, "communication step", step):
        Master(three(fmus)[:2], [], step)


def test_refuses_impossible_setups(fmus: Path) -> None:
    with raises(FmuError, "two FMUs", "plant"):
        Master([three(fmus)[1]] * 2, [], 2e-4)
    with raises(FmuError, "order", "'parallel'", "sequential", "jacobi"):
        Master(three(fmus), [], 2e-4, "parallel")   # type: ignore[arg-type]


def test_paths_and_times_as_text(fmus: Path) -> None:
    with Master([FmuSetup("plant", str(fmus / "Plant3DOF.fmu"))], [], "0.2 ms") as master:
        recording = master.run("1 ms")
    assert repr(master) == "<Master of plant: every 0.0002 s>"
    assert repr(recording) == f"<Recording: 6 points to 0.001 s, {len(recording.columns)} columns>"
    with raises(FmuError, "freed"):
        master.run(0.001)


class Doubled:
    """A class of a user's, with one input and one output."""

    inputs: ClassVar[dict[str, str]] = {"u": ""}
    outputs: ClassVar[dict[str, str]] = {"y": ""}

    def __init__(self) -> None:
        self.sample_time = 0.5
        self.u = self.y = 0.0

    def step(self, t: float) -> None:
        self.y = 2.0 * self.u


def test_takes_a_class_or_an_object_instead_of_a_path() -> None:
    for given in (Doubled, Doubled()):
        with Master([FmuSetup("law", given)], [], 0.5) as master:
            assert master.run(1.0, {"law.u": [1.0, 2.0, 3.0]}).columns["law.y"].tolist() == [0.0, 2.0, 4.0]
    with raises(ControllerError, "None"):
        FmuSetup("law", None)


def test_file_that_is_no_fmu(tmp_path: Path) -> None:
    path = tmp_path / "Plant.fmu"
    with raises(FmuError, path):
        Master([FmuSetup("plant", path)], [], 1e-3)
    path.write_bytes(b"not a zip")
    with raises(FmuError, path):
        Master([FmuSetup("plant", path)], [], 1e-3)
