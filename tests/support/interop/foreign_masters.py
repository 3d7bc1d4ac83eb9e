"""Masters that are not ours, each run as a script in a process of its own: they crash, print and load libraries.

`python foreign_masters.py TOOL REQUEST.json RESULT.npy` writes the recorded values after each step, shape
(steps, names). Exit code 77: the tool is installed but cannot be loaded here, and standard error says why.
"""

import ctypes
import json
import os
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, TypedDict

import numpy as np

CANNOT_LOAD = 77


class Request(TypedDict):
    """A closed loop to run.

    `fmus` are files by participant, in the order of stepping; names of variables are `fmu.variable`; `drives` has the
    values of inputs at the start of each step; `start` has start values, which fmpy's SSP simulation cannot take;
    `ssp` is the file of the same system, or None to wire the loop by hand.
    """

    fmus: dict[str, str]
    connections: list[tuple[str, str]]
    step: float
    drives: dict[str, list[float]]
    record: list[str]
    start: dict[str, float]
    ssp: str | None


def steps_of(request: Request) -> int:
    """Number of steps."""
    return len(next(iter(request["drives"].values())))


def fmpy_ssp(request: Request) -> Iterator[list[float]]:
    """fmpy.ssp: all ports start at 0.0, then the FMUs step, then the connections, those of the system too, transfer."""
    from fmpy.ssp.simulation import simulate_ssp
    from fmpy.ssp.ssd import read_ssv

    assert request["ssp"] is not None and not request["start"]
    given = Path(request["ssp"]).with_suffix(".ssv")
    step, steps = request["step"], steps_of(request)
    inputs = {name.partition(".")[2]: lambda t, values=values: values[round(t / step)]
              for name, values in request["drives"].items()}
    result = simulate_ssp(request["ssp"], stop_time=(steps - 0.5) * step, step_size=step, input=inputs,
                          parameter_set=read_ssv(given) if given.is_file() else None)
    assert len(result) == steps
    yield from zip(*(result[name].tolist() for name in request["record"]), strict=True)


def ecos(request: Request) -> Iterator[list[float]]:
    """ecos."""
    from ecospy import EcosSimulation, EcosSimulationStructure

    if request["ssp"] is not None:
        assert not request["start"]
        simulation = EcosSimulation(step_size=request["step"], ssp_path=request["ssp"])
    else:
        structure = EcosSimulationStructure()
        for name, path in request["fmus"].items():
            structure.add_model(name, path)
        for source, target in request["connections"]:
            structure.make_real_connection(ecos_name(source), ecos_name(target))
        structure.add_parameter_set("start", {ecos_name(name): value for name, value in request["start"].items()})
        simulation = EcosSimulation(step_size=request["step"], structure=structure)
    assert simulation.init(parameter_set="start" if request["start"] else None)
    for k in range(steps_of(request)):
        for name, values in request["drives"].items():
            simulation.set_real(ecos_name(name), values[k])
        simulation.step()
        yield [simulation.get_real(ecos_name(name)) for name in request["record"]]
    simulation.terminate()


def ecos_name(name: str) -> str:
    """`fmu::variable`."""
    return name.replace(".", "::", 1)


def cosim(request: Request) -> Iterator[list[float]]:
    """libcosim, whose times are whole nanoseconds."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.ERROR)
    step = round(request["step"] * 1e9)
    if request["ssp"] is not None:
        execution = CosimExecution.from_ssp_file(request["ssp"], step)
        numbers = {name: execution.slave_index_from_instance_name(name) for name in request["fmus"]}
    else:
        execution = CosimExecution.from_step_size(step)
        numbers = {name: execution.add_local_slave(CosimLocalSlave(path, name))
                   for name, path in request["fmus"].items()}
    references = {f"{name}.{variable.name.decode()}": (number, variable.reference)
                  for name, number in numbers.items() for variable in execution.slave_variables(number)}
    if request["ssp"] is None:
        for source, target in request["connections"]:
            assert execution.connect_real_variables(*references[source], *references[target]) == 0
    for name, value in request["start"].items():
        assert execution.real_initial_value(*references[name], value)
    manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    assert execution.add_manipulator(manipulator) and execution.add_observer(observer)
    for k in range(steps_of(request)):
        for name, values in request["drives"].items():
            number, reference = references[name]
            assert manipulator.slave_real_values(number, [reference], [values[k]])
        assert execution.step()
        yield [observer.last_real_values(number, [reference])[0]
               for number, reference in (references[name] for name in request["record"])]


TOOLS: dict[str, Any] = {"fmpy.ssp": fmpy_ssp, "ecos": ecos, "libcosim": cosim}


def load(tool: str) -> None:
    """Load a tool's libraries; ImportError or OSError if that fails."""
    if tool == "ecos":
        # Its library wants that of tbb, which pip puts where the loader does not look.
        ctypes.CDLL(os.path.join(sys.prefix, "lib", "libtbb.so.12"), mode=ctypes.RTLD_GLOBAL)
        import_module("ecospy")
    elif tool == "libcosim":
        import_module("libcosimpy._internal").libcosimc()


def main(tool: str, request: str, result: str) -> None:
    """Run a request."""
    with open(request, encoding="utf-8") as file:
        loop: Request = json.load(file)
    try:
        load(tool)
    except (ImportError, OSError) as error:
        print(f"{tool} cannot be loaded: {error}", file=sys.stderr)
        sys.exit(CANNOT_LOAD)
    np.save(result, np.array(list(TOOLS[tool](loop))))
    sys.stdout.flush()
    os._exit(0)   # what a tool does when its process ends is not what is asked here


if __name__ == "__main__":
    main(*sys.argv[1:])
