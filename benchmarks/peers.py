"""What the same blocks cost in other people's hands: a plain pythonfmu slave with fmpy's list calls, and fmpy.ssp."""

import shutil
import tempfile
from pathlib import Path
from time import perf_counter

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.ssp.simulation import simulate_ssp
from loops import Pair
from pythonfmu import FmuBuilder

from fmi_export.ssp import write_ssp
from maglev.own_fmus import DEFINITIONS, definition
from maglev.packages import PACKAGES

SLAVE = '''
from operator import attrgetter
from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Real
from {module} import {attribute} as DEFINITION


class Plain{name}(Fmi2Slave):
    """The block as a slave that registers its variables one by one, as pythonfmu's examples do."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.block = DEFINITION.new_block()
        for variable in DEFINITION.variables:
            path, _, attribute = variable.place.rpartition(".")
            owner = attrgetter(path)(self.block) if path else self.block
            kind = Boolean if variable.boolean else Real
            self.register_variable(kind(
                variable.name, causality=Fmi2Causality[variable.causality],
                variability=Fmi2Variability[variable.variability],
                getter=lambda owner=owner, attribute=attribute: getattr(owner, attribute),
                setter=lambda value, owner=owner, attribute=attribute: setattr(owner, attribute, value)))

    def exit_initialization_mode(self):
        self.block.start()

    def do_step(self, current_time, step_size):
        return self.block.step(current_time, step_size) == 0
'''

ROOT = Path(__file__).parents[1]


class ListComponent:
    """An FMU called with fmpy's lists, as its examples do."""

    def __init__(self, path: Path, folder: Path):
        description = fmpy.read_model_description(str(path), validate=False)
        fmpy.extract(str(path), str(folder))
        self.slave = FMU2Slave(guid=description.guid, unzipDirectory=str(folder), instanceName=path.stem,
                               modelIdentifier=description.coSimulation.modelIdentifier)
        self.slave.instantiate()
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        outputs = [v for v in description.modelVariables if v.causality == "output"]
        self.reals = [v.valueReference for v in outputs if v.type == "Real"]
        self.booleans = [v.valueReference for v in outputs if v.type == "Boolean"]


def plain_fmu(name: str, folder: Path) -> Path:
    """Build the plain slave of an FMU."""
    module, attribute = DEFINITIONS[name]
    script = folder / f"plain_{name.lower()}.py"
    script.write_text(SLAVE.format(module=module, attribute=attribute, name=name), encoding="utf-8")
    packages = [ROOT / package for package in (*PACKAGES, "fmi_export")]
    return Path(FmuBuilder.build_FMU(script, dest=folder, project_files=packages))


def list_loop(pair: Pair, steps: int) -> float:
    """Time of one step of plain slaves under a loop of fmpy's list calls, s."""
    folder = Path(tempfile.mkdtemp(prefix="maglev_peer_"))
    try:
        controller, plant = (ListComponent(plain_fmu(name, folder), folder / name)
                             for name in (pair.controller, pair.plant))
        measured = [plant.references[source] for source, _ in pair.measured]
        inputs = [controller.references[name] for name in (*(to for _, to in pair.measured),
                                                           *(f"{axis}.reference" for axis in pair.rig.axis_names))]
        phases = [f"{motor}.{phase}" for motor in pair.rig.motor_names for phase in ("i_a_cmd", "i_b_cmd", "i_c_cmd")]
        commands = [controller.references[name] for name in phases]
        currents = [plant.references[name] for name in phases]
        references = pair.starts
        record = []
        begin = perf_counter()
        for k in range(steps):
            time = k * pair.dt
            controller.slave.setReal(inputs, plant.slave.getReal(measured) + references)
            controller.slave.doStep(time, pair.dt)
            plant.slave.setReal(currents, controller.slave.getReal(commands))
            plant.slave.doStep(time, pair.dt)
            record.append([component.slave.getReal(component.reals) + component.slave.getBoolean(component.booleans)
                           for component in (controller, plant)])
        elapsed = (perf_counter() - begin) / steps
        for component in (controller, plant):
            component.slave.terminate()
            component.slave.freeInstance()
        return elapsed
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def ssp_loop(pair: Pair, fmus: Path, steps: int) -> float:
    """Time of one step of fmpy.ssp on the FMUs of a folder, s; the difference of two lengths, for it also unpacks."""
    with tempfile.TemporaryDirectory(prefix="maglev_peer_") as folder:
        path = write_ssp(Path(folder) / "loop.ssp",
                         {"controller": (definition(pair.controller), fmus / f"{pair.controller}.fmu"),
                          "plant": (definition(pair.plant), fmus / f"{pair.plant}.fmu")}, pair.connections, 1.0)
        given = {f"{axis}.reference": (lambda _, start=start: start)
                 for axis, start in zip(pair.rig.axis_names, pair.starts, strict=True)}
        times = []
        for count in (100, 100 + steps):
            begin = perf_counter()
            simulate_ssp(str(path), stop_time=(count - 0.5) * pair.dt, step_size=pair.dt, input=given)
            times.append(perf_counter() - begin)
        return (times[1] - times[0]) / steps
