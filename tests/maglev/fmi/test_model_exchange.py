"""Plants in model exchange: under CVODE, at stops, through states, with derivatives; what is refused."""

from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import byref, c_double, c_size_t, c_void_p
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from continuous_block import ContinuousBlock
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Model,
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.logging import addLoggerProxy

from maglev.descriptions.own_fmus import definition

START = {"alpha.i_a_cmd": 1.0, "alpha.i_b_cmd": -0.5, "alpha.i_c_cmd": -0.7, "beta.i_a_cmd": 0.9,
         "y.mode.frequency": 90.0, "y.position_start": 0.0222}

HEARD: list[str] = []   # what instances of FMI 2.0 say


@fmi2CallbackLoggerTYPE   # type: ignore[untyped-decorator]
def hear(_environment: object, _name: bytes, _status: int, _category: bytes, message: bytes) -> None:
    HEARD.append(message.decode())


@contextmanager
def exchanged(fmu: Path, folder: Path, kind: type | None = None) -> Iterator[Any]:
    """An instance for model exchange, in event mode; or of another of fmpy's classes."""
    description = fmpy.read_model_description(str(fmu))
    fmpy.extract(str(fmu), str(folder))
    version_2 = description.fmiVersion == "2.0"
    kind = kind or (FMU2Model if version_2 else FMU3Model)
    instance = kind(guid=description.guid, unzipDirectory=str(folder), instanceName="plant",
                    modelIdentifier=description.modelExchange.modelIdentifier)
    if version_2:
        # Its own: fmpy has one logger for all, that of whoever made the last instance.
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = hear
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
        addLoggerProxy(byref(callbacks))
        instance.instantiate(callbacks=callbacks, loggingOn=True)
        instance.setupExperiment()
    else:
        instance.instantiate(loggingOn=True)
    instance.enterInitializationMode()
    instance.exitInitializationMode()
    yield instance
    instance.freeInstance()


def calls_of(instance: Any) -> tuple[Any, Any, Any, Any]:
    """What sets and gets real variables, takes in an event, and gets the rates of the states."""
    if isinstance(instance, FMU2Model):
        return instance.setReal, instance.getReal, instance.newDiscreteStates, instance.getDerivatives
    return (instance.setFloat64, instance.getFloat64, instance.updateDiscreteStates,
            instance.getContinuousStateDerivatives)


def references(fmu: Path) -> dict[str, int]:
    return {v.name: v.valueReference for v in fmpy.read_model_description(str(fmu)).modelVariables}


def state_values(instance: Any, fmu: Path) -> dict[str, float]:
    """The continuous states by name."""
    names = [unknown.variable.derivative.name for unknown in fmpy.read_model_description(str(fmu)).derivatives]
    values = (c_double * len(names))()
    instance.getContinuousStates(values, len(values))
    return dict(zip(names, values, strict=True))


@pytest.fixture(params=[2, 3])
def plant(request: pytest.FixtureRequest, native_fmus: Path, fmi3_fmus: Path) -> Path:
    """The 3-DOF stage of a version of FMI."""
    return (native_fmus if request.param == 2 else fmi3_fmus) / "Plant3DOF.fmu"


def test_cvode_and_co_simulation_agree(plant: Path) -> None:
    """Over 0.1 s at 1e-10, from rest: 1e-9 m, 1e-6 m/s, and every count of the encoders."""
    simulated = [fmpy.simulate_fmu(str(plant), stop_time=0.1, output_interval=1e-3, fmi_type=kind, start_values=START,
                               relative_tolerance=1e-10, record_events=False)
             for kind in ("ModelExchange", "CoSimulation")]
    for axis in "yxz":
        for name, tolerance in ((f"{axis}.position", 1e-9), (f"{axis}.velocity", 1e-6), (f"{axis}.encoder", 1e-9)):
            assert np.abs(simulated[0][name] - simulated[1][name]).max() < tolerance
            assert np.ptp(simulated[0][name]) > 10 * tolerance, "it moves"


def test_into_a_stop(plant: Path) -> None:
    """The solver ends its step at the stop; two bounces later the two differ by less than docs/accuracy.md allows."""
    start = {"y.position_start": 0.0315, "y.friction.coulomb": 0.0}
    exchange, stepped = (fmpy.simulate_fmu(str(plant), stop_time=0.1, output_interval=1e-3, fmi_type=kind,
                                           start_values=start, relative_tolerance=1e-10, record_events=False)
                         for kind in ("ModelExchange", "CoSimulation"))
    assert exchange["at_stop"].any() and not exchange["at_stop"].all()
    assert np.abs(exchange["y.position"] - stepped["y.position"]).max() < 1e-5
    assert exchange["y.position"].max() > 0.0321


def test_derivatives_are_those_of_the_block(plant: Path, tmp_path: Path) -> None:
    """What the C functions give is what the same rules make of the Python block, to rounding; adjoint: transposed."""
    known = references(plant)
    block = ContinuousBlock("Plant3DOF", {})
    knowns = [*block.states, "alpha.i_b_cmd", "z.force"]
    unknowns = [*block.rates, "beta.i_q"]
    with exchanged(plant, tmp_path) as instance:
        if isinstance(instance, FMU2Model):
            instance.newDiscreteStates()
        else:
            instance.updateDiscreteStates()
        instance.enterContinuousTimeMode()
        states = (c_double * len(block.states))()
        instance.getContinuousStates(states, len(states))
        states[:] = [value + 1e-3 * (k % 7 - 3) for k, value in enumerate(states)]
        instance.setContinuousStates(states, len(states))
        expected = block.at(block.states, list(states), unknowns)
        rates = (c_double * len(states))()
        (instance.getDerivatives if isinstance(instance, FMU2Model) else instance.getContinuousStateDerivatives)(
            rates, len(rates))
        np.testing.assert_allclose(list(rates), expected[:-1], rtol=1e-12, atol=1e-12)
        jacobian = block.jacobian(unknowns, knowns)
        seed = [0.1 * (k % 5 - 2) for k in range(len(knowns))]
        of_unknowns, of_knowns = [known[name] for name in unknowns], [known[name] for name in knowns]
        found = instance.getDirectionalDerivative(of_unknowns, of_knowns, seed)
        scale = np.abs(jacobian).max()
        np.testing.assert_allclose(found, jacobian @ seed, rtol=1e-12, atol=1e-15 * scale)
        if isinstance(instance, FMU3Model):
            weights = [0.2 * (k % 3 - 1) for k in range(len(unknowns))]
            adjoint = instance.getAdjointDerivative(of_unknowns, of_knowns, weights, len(of_knowns))
            np.testing.assert_allclose(adjoint, np.array(weights) @ jacobian, rtol=1e-12, atol=1e-15 * scale)
        with pytest.raises(FMICallException):
            instance.getDirectionalDerivative([known["y.encoder"]], of_knowns, seed)
        with pytest.raises(FMICallException):
            instance.getDirectionalDerivative(of_unknowns, [known["C1"]], [1.0])


def test_discrete_outputs_change_in_event_mode_alone(plant: Path, tmp_path: Path) -> None:
    """A host that obeys the letter reads them at events, and has the encoders' counts after each of its steps."""
    known = references(plant)
    encoders = {f"{axis}.encoder": f"{axis}.position" for axis in "yxz"}
    discrete, positions = [known[name] for name in encoders], [known[name] for name in encoders.values()]
    step, events = 5e-5, 0
    with exchanged(plant, tmp_path) as instance:
        put, get, event, rates = calls_of(instance)
        put([known[name] for name in ("alpha.i_a_cmd", "alpha.i_b_cmd", "alpha.i_c_cmd")], [1.0, -0.5, -0.7])
        event()
        read = get(discrete)
        instance.enterContinuousTimeMode()
        count = len(state_values(instance, plant))
        states, slopes = (c_double * count)(), (c_double * count)()
        for k in range(400):
            instance.setTime((k + 1) * step)
            instance.getContinuousStates(states, count)
            rates(slopes, count)
            states[:] = [value + step * slope for value, slope in zip(states, slopes, strict=True)]   # Euler's method
            instance.setContinuousStates(states, count)
            asked, _ = instance.completedIntegratorStep()
            assert get(discrete) == read, "nothing changes between events"
            if asked:
                instance.enterEventMode()
                event()
                before, read = read, get(discrete)
                assert read != before, "there was a reason"
                instance.enterContinuousTimeMode()
                events += 1
            assert np.abs(np.array(read) - get(positions)).max() <= 0.5 * 1e-5 * (1.0 + 1e-9), "half a count"
    assert 20 < events < 200, "the mover passes counts, and not in every step"


def test_initial_derivatives_are_those_of_differences(plant: Path, tmp_path: Path) -> None:
    """Of every initial unknown by each real dependency, next to central differences; what is off at 0 is on."""
    description = fmpy.read_model_description(str(plant))
    fmpy.extract(str(plant), str(tmp_path))
    version_2 = description.fmiVersion == "2.0"
    instance = (FMU2Model if version_2 else FMU3Model)(
        guid=description.guid, unzipDirectory=str(tmp_path), instanceName="plant",
        modelIdentifier=description.modelExchange.modelIdentifier)
    instance.instantiate()
    if version_2:
        instance.setupExperiment()
    instance.enterInitializationMode()
    put, get, *_ = calls_of(instance)
    known = {v.name: v for v in description.modelVariables}
    on = {"ripple.amplitude": 0.3, "roughness.rms": 0.2, "friction.variation": 0.3, "mode.frequency": 90.0,
          "bus_voltage": 60.0, "i_a_cmd": 0.7, "i_b_cmd": -0.4, "position_start": 0.0212}
    for name, variable in known.items():
        for end, value in on.items():
            if name.endswith(end) and variable.causality in ("input", "parameter"):
                put([variable.valueReference], [value])
    by: dict[str, list[Any]] = {}
    for unknown in description.initialUnknowns:
        for each in unknown.dependencies if "Boolean" not in unknown.variable.type else ():
            if each.type != "Boolean" and each.name != "guide_seed":   # a whole number
                by.setdefault(each.name, []).append(unknown.variable)
    assert len(by) > 100 and [v.name for v in by["y.position_start"]][:1] == ["y.encoder"]
    for name, unknowns in by.items():
        reference, of = [known[name].valueReference], [v.valueReference for v in unknowns]
        value = get(reference)[0]
        push = 1e-5 * max(abs(value), 0.01 * float(known[name].nominal or 1.0))
        exact = np.array(instance.getDirectionalDerivative(of, reference, [1.0]))
        low = float(known[name].min) if known[name].min is not None else -np.inf
        ends = [max(value - push, low), value + push]
        values = [put(reference, [end]) or np.array(get(of)) for end in ends]
        put(reference, [value])
        scale = np.maximum(np.abs(values[0]), 1e-3) / push
        difference = (values[1] - values[0]) / (ends[1] - ends[0])
        assert (np.abs(difference - exact) <= 1e-5 * np.abs(exact) + 1e-11 * scale).all(), name
    y, x = (known[f"{axis}.position"].valueReference for axis in "yx")
    start = known["y.position_start"].valueReference
    assert instance.getDirectionalDerivative([y, x], [start], [2.0]) == [2.0, 0.0]
    with pytest.raises(FMICallException):   # a state follows from parameters here
        instance.getDirectionalDerivative([x], [y], [1.0])
    instance.freeInstance()


def test_encoders_have_derivatives_at_events(plant: Path, tmp_path: Path) -> None:
    """Of counts none but by their size, of an exact encoder those of its position."""
    known = references(plant)
    with exchanged(plant, tmp_path) as instance:
        put = calls_of(instance)[0]
        encoder, position = known["y.encoder"], known["y.position"]
        assert instance.getDirectionalDerivative([encoder], [position], [1.0]) == [0.0]
        put([known["encoder.resolution"]], [0.0])
        assert instance.getDirectionalDerivative([encoder, known["x.encoder"]], [position], [3.0]) == [3.0, 0.0]


def test_states_are_variables_that_can_be_set(plant: Path, tmp_path: Path) -> None:
    """By their names, as CasADi does: what all states at once give; rates and outputs that are none cannot be set."""
    known = references(plant)
    with exchanged(plant, tmp_path) as instance:
        put, got, event, rates = calls_of(instance)
        put([known["x.velocity"]], [0.2])   # at an event
        event()
        instance.enterContinuousTimeMode()
        states = state_values(instance, plant)
        assert states["x.velocity"] == 0.2
        moved = states | {"y.position": 0.023, "alpha.i_b": 1.5, "x.friction.deflection": 0.4, "beta.phase_a.heat": 2.0}
        put([known[name] for name in moved], list(moved.values()))
        assert state_values(instance, plant) == moved
        of_names, of_all = (c_double * len(moved))(), (c_double * len(moved))()
        rates(of_names, len(moved))
        instance.setContinuousStates((c_double * len(moved))(*states.values()), len(moved))
        instance.setContinuousStates((c_double * len(moved))(*moved.values()), len(moved))
        rates(of_all, len(moved))
        assert list(of_names) == list(of_all)
        for name, value in (("y.position", np.inf), ("der(y.velocity)", 0.0), ("y.encoder", 0.02)):
            with pytest.raises(FMICallException):
                put([known[name]], [value])
        assert got([known["y.position"]]) == [0.023]
    slave = FMU2Slave if isinstance(instance, FMU2Model) else FMU3Slave
    with pytest.raises(FMICallException), exchanged(plant, tmp_path, slave) as stepped:
        (stepped.setReal if slave is FMU2Slave else stepped.setFloat64)([known["y.position"]], [0.023])


def test_states_but_positions_begin_at_nothing() -> None:
    """As the initial unknowns say, whatever the parameters are."""
    for stage in ("2DOF", "3DOF", "5DOF"):
        block = ContinuousBlock(f"Plant{stage}", {})
        plant = definition(f"Plant{stage}")
        for number, v in enumerate(v for v in plant.variables if v.causality == "parameter" and not v.boolean):
            if v.name != "guide_seed":   # a whole number
                block.set(v.name, plant.start_value(v) * (1.0 + 0.001 * (number % 7)) + 1e-6 * (number % 5))
        assert block.block.start() == 0
        outputs = {v.name for v in plant.variables if v.causality == "output"}
        assert not block.get([name for name in block.states if name not in outputs]).any()


def test_parameters_change_at_events(native_fmus: Path, tmp_path: Path) -> None:
    """A fault in event mode takes the current away; between events no parameter can be set, inputs can."""
    fmu = native_fmus / "Plant3DOF.fmu"
    known = references(fmu)
    with exchanged(fmu, tmp_path) as plant:
        plant.setReal([known["alpha.i_a_cmd"]], [7.0])
        assert plant.newDiscreteStates()[3] == 1, "the lag starts at the first clamped command"
        plant.enterContinuousTimeMode()
        assert plant.getReal([known["alpha.i_a"]]) == [5.0] and plant.getBoolean([known["alpha.saturated"]]) == [True]
        plant.setReal([known["y.force"]], [1.0])
        with pytest.raises(FMICallException):
            plant.setReal([known["C1"]], [0.5])
        before = state_values(plant, fmu)
        plant.enterEventMode()
        plant.enterEventMode()   # allowed in both modes
        plant.setBoolean([known["alpha.phase_a.open"]], [True])
        assert plant.newDiscreteStates()[3] == 1
        assert plant.getReal([known["alpha.i_a"]]) == [0.0]
        after = state_values(plant, fmu)
        jumped = {name for name in before if after[name] != before[name]}
        description = ElementTree.parse(tmp_path / "modelDescription.xml")
        told = {v.get("name") for v in description.iter("ScalarVariable") if v.find("Real[@reinit='true']") is not None}
        assert jumped == {"alpha.i_a"} and told == {f"{m}.i_{p}" for m in ("alpha", "beta") for p in "abc"}
        with pytest.raises(FMICallException):
            plant.setReal([known["y.mass"]], [-1.0])


def test_refusals_say_what_was_expected(native_fmus: Path, tmp_path: Path) -> None:
    """A wrong phase, states that are no numbers, a mover that ran away, a call of the other interface."""
    fmu = native_fmus / "Plant3DOF.fmu"
    with exchanged(fmu, tmp_path) as plant:
        plant.newDiscreteStates()
        plant.enterContinuousTimeMode()
        start = state_values(plant, fmu)

        def move(changes: dict[str, float]) -> None:
            values = (c_double * len(start))(*(start | changes).values())
            plant.setContinuousStates(values, len(values))
            plant.getDerivatives(values, len(values))

        for call, said in (
                (plant.newDiscreteStates, "fmi2NewDiscreteStates in continuous-time mode, expected in event mode"),
                (lambda: move({"alpha.i_a": np.nan}), "alpha.i_a = nan, expected a finite number"),
                (lambda: move({"y.position": 2e3}), "y.position = 2000.0 m, x.position = 0.0 m, z.position = 0.0 m, "
                                                    "expected all within 1000 m and slower than 1e6 m/s")):
            with pytest.raises(FMICallException):
                call()
            assert said in HEARD.pop()
        move({})
        assert state_values(plant, fmu) == start, "an integrator continues from another point"
        with exchanged(fmu, tmp_path / "beside", FMU2Slave) as beside:
            assert beside.dll.fmi2GetDerivatives(c_void_p(beside.component), (c_double * 29)(), c_size_t(29)) == 3
            beside.doStep(0.0, 2e-4)
        assert "fmi2GetDerivatives of an instance for co-simulation, expected one for" in HEARD.pop()
        plant.terminate()
        assert state_values(plant, fmu) == start


def test_controllers_are_for_co_simulation_alone(native_fmus: Path, tmp_path: Path) -> None:
    fmu = native_fmus / "Regulator3DOF.fmu"
    description = fmpy.read_model_description(str(fmu))
    assert description.modelExchange is None and description.coSimulation is not None
    fmpy.extract(str(fmu), str(tmp_path))
    instance = FMU2Model(guid=description.guid, unzipDirectory=str(tmp_path), instanceName="regulator",
                         modelIdentifier=description.coSimulation.modelIdentifier)
    with pytest.raises(Exception, match="[Ii]nstantiate"):
        instance.instantiate()
