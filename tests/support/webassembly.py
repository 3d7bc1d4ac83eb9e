"""FMUs as WebAssembly modules, run by wasmtime as the master runs FMUs."""

import ctypes
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from wasmtime import Engine, Instance, Module, Store

from maglev.scenario.run_plan import RunPlan

OK, CO_SIMULATION = 0, 1


class WebAssemblyFmu:
    """An instance of a module, set up and initialized from time 0; its variables are set and got by name."""

    def __init__(self, folder: Path, name: str, start: dict[str, float | bool] | None = None):
        self.description = fmpy.read_model_description(str(folder / f"{name}.xml"))
        self.variables = {v.name: v for v in self.description.modelVariables}
        engine = Engine()
        module = Module.from_file(engine, str(folder / f"{name}.wasm"))
        self.imports = list(module.imports)
        self.store = Store(engine)
        # Functions and the memory; which is which, a name does not say.
        self.exports: dict[str, Any] = dict(Instance(self.store, module, []).exports(self.store))
        self.exports["_initialize"](self.store)
        guid = self.description.guid.encode()
        self.component = self.exports["fmi2Instantiate"](
            self.store, self.text(name.encode()), CO_SIMULATION, self.text(guid), 0, self.call("maglevCallbacks"), 0, 1)
        assert self.component, self.message()
        self.checked("fmi2SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
        for variable, value in (start or {}).items():
            self.set(variable, value)
        self.checked("fmi2EnterInitializationMode")
        self.checked("fmi2ExitInitializationMode")

    def call(self, function: str, *arguments: float) -> int:
        """Call a function of the module."""
        result: int = self.exports[function](self.store, *arguments)
        return result

    def checked(self, function: str, *arguments: float) -> None:
        """Call a function of FMI that must not refuse."""
        assert self.call(function, self.component, *arguments) == OK, self.message()

    def text(self, text: bytes) -> int:
        """Address of a text in the module's memory."""
        address = self.call("malloc", len(text) + 1)
        self.exports["memory"].write(self.store, text + b"\0", address)
        return address

    def message(self) -> str:
        """What the FMU said last."""
        address = self.call("maglevMessage")
        data = self.exports["memory"].read(self.store, address, address + 2000)
        return bytes(data).split(b"\0")[0].decode()

    def view(self, address: int, count: int, kind: Any) -> np.ndarray:
        """The module's memory as an array, until the memory grows."""
        start = ctypes.addressof(self.exports["memory"].data_ptr(self.store).contents)
        return np.ctypeslib.as_array((kind * count).from_address(start + address))

    def ports(self, names: list[str]) -> tuple[int, int, np.ndarray]:
        """Addresses of value references and of values, and the values, of Real variables."""
        references = self.call("malloc", 4 * len(names))
        values = self.call("malloc", 8 * len(names))
        self.view(references, len(names), ctypes.c_uint32)[:] = [self.variables[n].valueReference for n in names]
        return references, values, self.view(values, len(names), ctypes.c_double)

    def set(self, name: str, value: float | bool) -> None:
        """Set a variable."""
        references, values, view = self.ports([name])
        if self.variables[name].type == "Boolean":
            self.view(values, 1, ctypes.c_int32)[0] = value
            self.checked("fmi2SetBoolean", references, 1, values)
        else:
            view[0] = value
            self.checked("fmi2SetReal", references, 1, values)


def simulated(folder: Path, plan: RunPlan, drives: Mapping[str, Sequence[float] | np.ndarray],
          stop_time: float) -> dict[str, np.ndarray]:
    """Real outputs, `fmu.variable`, of a run at every communication point until the stop time (s)."""
    fmus = {name: WebAssemblyFmu(folder, str(fmu.model), {key: start.value for key, start in fmu.start.items()})
            for name, fmu in plan.fmus.items()}
    steps = round(stop_time / plan.step)
    columns: dict[str, np.ndarray] = {}
    gets, sets = {}, {}
    for name, fmu in fmus.items():
        outputs = [v.name for v in fmu.description.modelVariables if v.causality == "output" and v.type == "Real"]
        gets[name] = (outputs, *fmu.ports(outputs))
        columns |= {f"{name}.{output}": np.zeros(steps + 1) for output in outputs}
    sources = {target: source for source, target in plan.wires.values()} | {target: target for target in drives}
    for name, fmu in fmus.items():
        fed = [target for target in sources if target.startswith(f"{name}.")]
        sets[name] = (fed, *fmu.ports([target.partition(".")[2] for target in fed]))
    now: dict[str, float] = {}

    def get(name: str, row: int) -> None:
        outputs, references, values, view = gets[name]
        fmus[name].checked("fmi2GetReal", references, len(outputs), values)
        for output, value in zip(outputs, view.tolist(), strict=True):
            now[f"{name}.{output}"] = columns[f"{name}.{output}"][row] = value

    for name in fmus:
        get(name, 0)
    for k in range(steps):
        for name, fmu in fmus.items():
            fed, references, values, view = sets[name]
            view[:] = [drives[target][k] if target in drives else now[sources[target]] for target in fed]
            fmu.checked("fmi2SetReal", references, len(fed), values)
            fmu.checked("fmi2DoStep", k * plan.step, plan.step, 1)
            get(name, k + 1)
    return columns
