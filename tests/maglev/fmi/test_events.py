"""Event mode of FMI 3.0 of what samples: with time events, and with a clock; fmpy is the importer."""

from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from event_mode import SAMPLE, Instance, unpacked
from fmpy.fmi3 import FMU3Slave
from fmpy_validation import validate_fmu

NAME = "Regulator3DOF"


@pytest.fixture
def by_time(fmi3_fmus: Path, tmp_path: Path) -> Instance:
    return Instance(unpacked(fmi3_fmus / f"{NAME}.fmu", tmp_path)).begin()


@pytest.fixture
def by_clock(clocked_fmus: Path, tmp_path: Path) -> Instance:
    return Instance(unpacked(clocked_fmus / f"{NAME}.fmu", tmp_path))


@pytest.mark.few(1)
@pytest.mark.parametrize("interval", [SAMPLE, 3.3 * SAMPLE, 20 * SAMPLE])
def test_fmpy_chooses_its_steps(fmi3_fmus: Path, interval: float) -> None:
    """With event mode and early return, each sample is what steps on the grid give, whatever the step."""
    path = str(fmi3_fmus / f"{NAME}.fmu")
    time = np.arange(61) * SAMPLE
    signals = np.zeros(61, dtype=[("time", float), ("y.measured", float), ("x.reference", float)])
    signals["time"], signals["y.measured"] = time, 0.025 + 1e-4 * np.sin(300.0 * time)
    signals["x.reference"] = 1e-3 * np.sin(100.0 * time)

    def simulated(step: float, **options: bool) -> Any:
        return fmpy.simulate_fmu(path, fmi_type="CoSimulation", stop_time=time[-1], output_interval=step, input=signals,
                                 output=["alpha.i_a_cmd", "y.error", "saturated"], **options)

    expected = simulated(SAMPLE)
    found = simulated(interval, use_event_mode=True, early_return_allowed=True)
    assert np.ptp(expected["alpha.i_a_cmd"]) > 0.1
    for k in range(60):
        last = np.flatnonzero(np.isclose(found["time"], time[k], rtol=0.0, atol=1e-9))[-1]   # after the event
        assert list(found[last])[1:] == list(expected[k + 1])[1:]


def test_a_sample_is_announced_and_ends_a_step_early(by_time: Instance) -> None:
    fmu = by_time.fmu
    unset = by_time.command()
    by_time.measure(0.0251)
    first = by_time.command()                     # as if nothing had been asked for before
    assert first != unset
    assert fmu.updateDiscreteStates()[4:] == (True, SAMPLE)
    fmu.enterStepMode()
    assert fmu.doStep(0.0, 0.7 * SAMPLE) == (False, False, False, 0.7 * SAMPLE)
    by_time.measure(0.0253)
    assert fmu.doStep(0.7 * SAMPLE, 5.0 * SAMPLE) == (True, False, True, SAMPLE)
    assert by_time.command() == first             # held, although the input has changed
    fmu.enterEventMode()
    assert fmu.updateDiscreteStates()[4:] == (True, 2.0 * SAMPLE)
    assert by_time.command() != first
    fmu.enterStepMode()
    assert fmu.doStep(SAMPLE, SAMPLE) == (True, False, False, 2.0 * SAMPLE)
    assert fmu.doStep(2.0 * SAMPLE, SAMPLE) == (True, False, True, 2.0 * SAMPLE), "the event was passed over"


def test_samples_of_a_time_as_computers_count_it(fmi3_fmus: Path, tmp_path: Path) -> None:
    """From 1.7e9 s on, which doubles resolve to 0.24 µs: the events are at the samples, and not next to them."""
    one, start = Instance(unpacked(fmi3_fmus / f"{NAME}.fmu", tmp_path)), 1.7e9
    one.begin(start)
    for k in range(20):
        _, _, _, _, defined, due = one.fmu.updateDiscreteStates()
        assert defined and due == start + (k + 1) * SAMPLE
        one.fmu.enterStepMode()
        half = start + (k + 0.5) * SAMPLE
        assert one.fmu.doStep(start + k * SAMPLE, half - (start + k * SAMPLE)) == (False, False, False, half)
        assert one.fmu.doStep(half, 5 * SAMPLE) == (True, False, True, due)
        one.fmu.enterEventMode()


def test_without_early_return_no_sample_is_passed_over(fmi3_fmus: Path, tmp_path: Path) -> None:
    one = Instance(unpacked(fmi3_fmus / f"{NAME}.fmu", tmp_path), early=False).begin()
    said = one.refusal(one.fmu.enterStepMode)
    assert said.startswith("fmi3EnterStepMode at t = 0.0 s, where a sample is due, expected an update")
    one.fmu.updateDiscreteStates()
    one.fmu.enterStepMode()
    assert one.refusal(lambda: one.fmu.doStep(0.0, 0.001)) == (
        "communication step from 0.0 s to 0.001 s, expected one to 0.0002 s at most, where the next sample is due")


def test_description_of_the_clock(clocked_fmus: Path) -> None:
    """Inputs and outputs are of the clock, which leaves its interval to the parameter; a plant has none."""
    assert [validate_fmu(str(clocked_fmus / f"{name}.fmu")) for name in (NAME, "Plant3DOF")] == [[], []]
    clock, = (v for v in fmpy.read_model_description(str(clocked_fmus / f"{NAME}.fmu")).modelVariables
              if v.type == "Clock")
    assert (clock.name, clock.causality, clock.intervalVariability) == ("clock", "input", "fixed")
    for v in fmpy.read_model_description(str(clocked_fmus / f"{NAME}.fmu")).modelVariables:
        of = [each.name for each in v.clocks or ()]
        assert (of, v.variability) == (["clock"], "discrete") if v.causality in ("input", "output") and v is not clock \
            and v.type != "Clock" else of == []


def test_the_interval_is_the_sample_time(by_clock: Instance) -> None:
    fmu = by_clock.fmu
    assert "fmi3GetIntervalDecimal before fmi3EnterInitializationMode" in by_clock.refusal(by_clock.interval)
    fmu.enterInitializationMode()
    assert [by_clock.interval(), by_clock.interval()] == [(SAMPLE, 2), (SAMPLE, 1)]
    fmu.setFloat64([by_clock.references["sample_time"]], [1e-4])
    assert [by_clock.interval(), by_clock.interval()] == [(1e-4, 2), (1e-4, 1)]
    fmu.exitInitializationMode()
    assert by_clock.interval() == (1e-4, 1)


def test_ticks_that_are_refused(by_clock: Instance) -> None:
    fmu = by_clock.begin().fmu
    belongs = "belongs to the clock, expected access to it in event mode while the clock is active"
    assert by_clock.refusal(by_clock.command) == f"alpha.i_d_cmd {belongs}"
    by_clock.tick()
    by_clock.measure(0.0251)
    by_clock.command()
    fmu.updateDiscreteStates()
    assert by_clock.refusal(by_clock.tick) == "clock = active at t = 0.0 s, expected its next tick at 0.0002 s"
    fmu.enterStepMode()
    assert by_clock.refusal(lambda: by_clock.measure(0.025)) == f"y.measured {belongs}"
    assert fmu.doStep(0.0, 0.5 * SAMPLE) == (False, False, False, 0.5 * SAMPLE)
    fmu.enterEventMode()
    assert by_clock.refusal(by_clock.tick) == "clock = active at t = 0.0001 s, expected its next tick at 0.0002 s"
    assert "clock = inactive, expected active" in by_clock.refusal(
        lambda: fmu.setClock([by_clock.references["clock"]], [False]))
    fmu.updateDiscreteStates()
    fmu.enterStepMode()
    state = fmu.getFMUState()
    assert "s, expected one to 0.0002 s at most" in by_clock.refusal(lambda: fmu.doStep(1e-4, 3e-4))
    fmu.setFMUState(state)
    fmu.doStep(1e-4, 1e-4)
    assert by_clock.refusal(lambda: fmu.doStep(SAMPLE, 1e-4)) == (
        "communication step from 0.0002 s, expected event mode before it with the clock active, as a sample is due at "
        "0.0002 s")


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize(("kind", "name", "events", "reason"), [
    ("clocked_fmus", NAME, False, "eventModeUsed = false, expected true: this FMU has a clock"),
    ("clocked_fmus", "Plant3DOF", True, "this FMU has no event mode")])
def test_who_wants_event_mode(request: pytest.FixtureRequest, tmp_path: Path, kind: str, name: str, events: bool,
                              reason: str) -> None:
    path = request.getfixturevalue(kind) / f"{name}.fmu"
    fmu = FMU3Slave(guid=fmpy.read_model_description(str(path)).guid, unzipDirectory=fmpy.extract(str(path), tmp_path),
                    modelIdentifier=name, instanceName="one")
    said: list[bytes] = []
    with pytest.raises(Exception, match="Failed to instantiate"):
        fmu.instantiate(eventModeUsed=events, logMessage=lambda *message: said.append(message[-1]))
    assert reason in said[0].decode()
