"""What FMUs of others give back is looked at: a step counts when it was made, a number when it is one."""

import zipfile
from pathlib import Path

import numpy as np
import pytest
from facts import raises
from small_fmus import small_fmu

from maglev.cosim.master import FmuSetup, Master, Recording, RunFailed
from maglev.cosim.step_loop import build_loop
from maglev.files.errors import FmuError

STEP, END = 0.05, 0.3   # s

NOT_MADE = {
    "early at the start": ("*early = true; *last = time;", "0.1"),
    "early halfway": ("*early = true; *last = time + 0.5 * step;", "0.125"),
    "early just before the end": ("*early = true; *last = time + (1.0 - 1e-5) * step;", "0.1499995"),
    "early at no time": ("*early = true; *last = NAN;", "nan"),
    "early and silent": ("*early = true;", "nan")}


@pytest.fixture(params=["in C", "in Python"])
def loop(request: pytest.FixtureRequest, slow: None) -> object:
    """The loop that makes the steps, as a `Master` takes it."""
    return build_loop() if request.param == "in C" else None


def simulated(fmu: Path, loop: object = None) -> Recording:
    with Master([FmuSetup("small", fmu)], [], STEP, loop=loop) as master:   # type: ignore[arg-type]
        return master.run(END, {"small.u": np.zeros(7)})


def refused(fmu: Path, *facts: object, loop: object = None) -> int:
    """Number of points that are kept of a run that does not go to its end, whose message has the facts."""
    with raises(RunFailed, *facts) as failure:
        simulated(fmu, loop)
    return len(failure.value.recording.time)


@pytest.mark.few(4)
@pytest.mark.parametrize("what", NOT_MADE)
def test_a_step_counts_only_when_it_was_made(tmp_path: Path, loop: object, what: str) -> None:
    statement, last = NOT_MADE[what]
    fmu = small_fmu(tmp_path, {"IN_STEP": f"if (late(f)) {{ {statement} }}"})
    assert refused(fmu, "0.1 s", "small.fmu", "fmi3DoStep", "discard", f"{last} s", "0.15 s", loop=loop) == 3


@pytest.mark.few(4)
@pytest.mark.parametrize("statement", ["*early = true; *last = time + step;", "*last = time;", "*last = NAN;",
                                       "*early = true; *last = (time + step) * (1.0 + 1e-15);",
                                       "*event = true; *early = false;"])
def test_a_step_that_was_made_counts_whatever_else_is_said(tmp_path: Path, loop: object, statement: str) -> None:
    """A last successful time is looked at where a step was left early."""
    recording = simulated(small_fmu(tmp_path, {"IN_STEP": statement}), loop)
    np.testing.assert_allclose(recording.columns["small.y"], np.exp(-recording.time), rtol=1e-12)


def test_an_fmu_that_asks_for_the_end_says_so(tmp_path: Path, loop: object) -> None:
    fmu = small_fmu(tmp_path, {"IN_STEP": "if (late(f)) *ends = true;"})
    assert refused(fmu, "0.1 s", "small.fmu", "fmi3DoStep", "discard", "asks for the end", loop=loop) == 3


@pytest.mark.few(3)
@pytest.mark.parametrize("value", [2, 7, 255])
def test_a_boolean_is_0_or_1(tmp_path: Path, loop: object, value: int) -> None:
    """Refused with what came before it, whatever step of the block it is in."""
    fmu = small_fmu(tmp_path, {"IN_FLAGS": f"if (late(f)) ((unsigned char *)value)[0] = {value};"})
    assert refused(fmu, "0.1 s", "small.b", value, "Boolean", loop=loop) == 3
    at_once = small_fmu(tmp_path, {"IN_FLAGS": f"((unsigned char *)value)[0] = {value};"})
    refused(at_once, "0 s", "small.b", value, "Boolean", loop=loop)


@pytest.mark.parametrize("exchange", [False, True])
def test_an_error_in_the_end_fails_the_run(tmp_path: Path, exchange: bool) -> None:
    fmu = small_fmu(tmp_path, {"IN_TERMINATE": "return fmi3Error;"}, exchange)
    assert refused(fmu, "0.3 s", "small.fmu", "fmi3Terminate") == 7


WARNINGS = {
    "of a step": ({"IN_STEP": "return fmi3Warning;"}, "a warning from fmi3DoStep, without a text (6 times)"),
    "of one step": ({"IN_STEP": "if (fabs(time - 0.1) < 1e-9) return fmi3Warning;"},
                    "a warning from fmi3DoStep, without a text"),
    "of values": ({"IN_FLAGS": "return fmi3Warning;"},
                  "a warning from fmi3GetBoolean of b, without a text (7 times)"),
    "of the initialization": ({"IN_INITIALIZATION": "return fmi3Warning;"},
                              "a warning from fmi3EnterInitializationMode, without a text"),
    "of the end": ({"IN_TERMINATE": "return fmi3Warning;"}, "a warning from fmi3Terminate, without a text"),
    "with a text": ({"IN_STEP": 'f->log(f->environment, fmi3Warning, "logStatusWarning", "the gap is odd"); '
                                "return fmi3Warning;"}, "the gap is odd (6 times)"),
    "a text alone": ({"IN_STEP": 'f->log(f->environment, fmi3Warning, "logStatusWarning", "the gap is odd");'},
                     "the gap is odd (6 times)")}


@pytest.mark.few(5)
@pytest.mark.parametrize("what", WARNINGS)
def test_a_warning_is_printed_once(tmp_path: Path, loop: object, what: str) -> None:
    holes, said = WARNINGS[what]
    recording = simulated(small_fmu(tmp_path, holes), loop)
    assert recording.notes == (f"small (small.fmu) says: {said}",)
    assert len(recording.time) == 7


def test_a_flaw_of_a_description_is_reported_with_the_run(tmp_path: Path) -> None:
    fmu = small_fmu(tmp_path, {})
    with zipfile.ZipFile(fmu) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(fmu, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data.replace(b'start="0"/>', b'start="0" unit="1"/>'))
    note, = simulated(fmu).notes
    assert note.startswith("small (small.fmu) runs, but its model description is flawed: The unit \"1\" of variable")


EXCHANGE: dict[str, tuple[dict[str, str], *tuple[str, ...]]] = {
    "an indicator": ({"IN_INDICATORS": "if (f->time > AT) value[0] = NAN;"}, "event indicator 1", "nan"),
    "an event in the past": ({"IN_UPDATE": "if (late(f)) { *defined = true; *next = f->time - 0.01; }"},
                             "next event time", "0.09 s", "0.1 s"),
    "an event at no time": ({"IN_UPDATE": "if (late(f)) { *defined = true; *next = NAN; }"},
                            "next event time", "nan s", "0.1 s"),
    "an event that is now, for ever": ({"IN_UPDATE": "if (late(f)) { *defined = true; *next = f->time; }"},
                                       "1000 events")}
NOMINALS = {"0.0": "0", "-1.0": "-1", "1e308": "1e+308", "NAN": "nan", "INFINITY": "inf", "1e-300": "1e-300"}


@pytest.mark.parametrize("what", EXCHANGE)
def test_what_an_fmu_for_model_exchange_gives_is_looked_at(tmp_path: Path, what: str) -> None:
    holes, *facts = EXCHANGE[what]
    # An event at the end of a step is one of this step.
    time, kept = ("0.1", 3) if what in ("an indicator", "an event that is now, for ever") else ("0.05", 2)
    assert refused(small_fmu(tmp_path, holes, True), f"{time} s", "small.fmu", "fmi3DoStep", *facts) == kept


def test_rates_that_are_no_numbers_end_the_run(tmp_path: Path) -> None:
    """The solver looks for a step without them, and finds none."""
    fmu = small_fmu(tmp_path, {"IN_RATES": "if (f->time > AT) value[0] = NAN;"}, True)
    assert refused(fmu, "small.fmu", "fmi3DoStep", "CVode") in (2, 3)


@pytest.mark.parametrize("value", NOMINALS)
def test_a_nominal_value_sets_a_tolerance(tmp_path: Path, value: str) -> None:
    fmu = small_fmu(tmp_path, {"IN_NOMINALS": f"value[0] = {value};"}, True)
    refused(fmu, "0 s", "small.fmu", "nominal value 1", NOMINALS[value], "x", "1e-60", "1e+60")


@pytest.mark.parametrize(("hole", "what"), [("INDICATORS", "EventIndicators"), ("STATES", "ContinuousStates")])
@pytest.mark.parametrize("count", [0, 2])
def test_counts_are_those_of_the_description(tmp_path: Path, hole: str, what: str, count: int) -> None:
    refused(small_fmu(tmp_path, {hole: str(count)}, True), "0 s", "small.fmu", f"fmi3GetNumberOf{what}", count, 1)


@pytest.mark.parametrize("holes", [{}, {"IN_UPDATE": "*defined = true; *next = f->time + 0.013;"},
                                   {"IN_NOMINALS": "value[0] = 1e-9;"}])
def test_a_correct_fmu_for_model_exchange_runs(tmp_path: Path, holes: dict[str, str]) -> None:
    """With its event as x passes 0.5, and events of its own between the steps."""
    recording = simulated(small_fmu(tmp_path, holes, True))
    np.testing.assert_allclose(recording.columns["small.y"], np.exp(-recording.time), rtol=1e-6)
    assert recording.notes == ()


def test_a_status_that_fmi_does_not_know_in_the_initialization(tmp_path: Path) -> None:
    fmu = small_fmu(tmp_path, {"IN_INITIALIZATION": "return (fmi3Status)-1;"})
    with raises(FmuError, "small.fmu", "fmi3EnterInitializationMode", "-1"):
        simulated(fmu)
