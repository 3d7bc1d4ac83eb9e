"""State of an FMU: saved, restored, serialized, moved to another instance; and reset."""

import json
from collections.abc import Callable

import pytest
from fmu_access import bits, put, read, refusal, step, variables

from maglev.cosim.fmu import Fmu

Load = Callable[[str], Fmu]


def started(load: Load, name: str) -> Fmu:
    component = load(name)
    component.initialise({}, 0.0, 10.0)
    return component


def thrust(name: str) -> str:
    """A tunable parameter of an FMU."""
    return "plant.C1" if name.startswith("ClosedLoop") else "C1"


def excite(component: Fmu) -> Callable[[int, float], None]:
    """Inputs that move everything: integrators, observers, friction, amplifiers, a stop."""
    inputs = [v for v in variables(component, "input") if v.type == "Real"]

    def set_inputs(k: int, _time: float) -> None:
        put(component, {v.name: (3.0 * ((k * (i + 3)) % 11 - 5) / 5.0 if v.unit in ("A", "N") else
                                 float(v.start) + 1e-4 * ((k * (i + 2)) % 7 - 3))
                        for i, v in enumerate(inputs)})

    return set_inputs


@pytest.mark.parametrize(("name", "size"), [("Plant2DOF", 5e-4), ("Plant3DOF", 2e-4), ("Regulator2DOF", 2.5e-4),
                                            ("Regulator3DOF", 2e-4), ("ClosedLoop3DOF", 1e-3)])
class TestState:
    """Of both kinds; communication steps of half the sample time for a controller, and of five for a closed loop."""

    @pytest.fixture
    def load(self, load_either: Load) -> Load:
        return load_either

    def test_restored_state_replays_bit_for_bit(self, load: Load, name: str, size: float) -> None:
        component = started(load, name)
        step(component, 0, 31, size, excite(component))
        state = component.instance.getFMUState()
        first = step(component, 31, 40, size, excite(component))
        component.instance.setFMUState(state)
        assert bits(step(component, 31, 40, size, excite(component))) == bits(first)
        component.instance.freeFMUState(state)

    def test_serialized_state_moves_to_another_instance(self, load: Load, name: str, size: float) -> None:
        component, other = started(load, name), started(load, name)
        step(component, 0, 31, size, excite(component))
        state = component.instance.getFMUState()
        data = component.instance.serializeFMUstate(state)
        first = step(component, 31, 40, size, excite(component))
        other.instance.setFMUState(other.instance.deSerializeFMUstate(data))
        assert bits(step(other, 31, 40, size, excite(other))) == bits(first)

    def test_state_holds_parameters(self, load: Load, name: str, size: float) -> None:
        component = started(load, name)
        state = component.instance.getFMUState()
        put(component, {thrust(name): 1.25})
        component.instance.setFMUState(state)
        assert read(component, thrust(name)) == float(component.variable(thrust(name)).start)

    def test_reset_equals_new_instance(self, load: Load, name: str, size: float) -> None:
        component, fresh = started(load, name), started(load, name)
        put(component, {thrust(name): 1.25})
        step(component, 0, 20, size, excite(component))
        component.instance.reset()
        component.initialise({}, 0.0, 10.0)
        assert bits(step(component, 0, 50, size, excite(component))) == bits(step(fresh, 0, 50, size, excite(fresh)))


def test_state_of_another_model_is_refused(load: Load) -> None:
    one, other = started(load, "Plant2DOF"), started(load, "Plant3DOF")
    data = one.instance.serializeFMUstate(one.instance.getFMUState())
    state = other.instance.deSerializeFMUstate(data)
    assert "plant2dof" in refusal(other, lambda: other.instance.setFMUState(state))


def test_garbled_state_is_refused(load: Load) -> None:
    component = started(load, "Plant2DOF")
    state = component.instance.deSerializeFMUstate(b"\x00garbage")
    assert "8 unreadable bytes" in refusal(component, lambda: component.instance.setFMUState(state))


@pytest.mark.parametrize("change", [{"block": []}, {"block": ["1"]}, {"block": None}, {"slave": []}, {"slave": 7},
                                    {"slave": ["asleep", False, 0.0, 1.0]}], ids=range(6))
def test_refuses_a_state_of_another_fmu(load: Load, change: dict[str, object]) -> None:
    component = started(load, "Plant2DOF")
    data = json.loads(component.instance.serializeFMUstate(component.instance.getFMUState()))
    state = component.instance.deSerializeFMUstate(json.dumps(data | change).encode())
    assert "expected one that this FMU has written" in refusal(component, lambda: component.instance.setFMUState(state))
