"""A user's class in a co-simulation: the functions of an FMU, in this process, without a file of its own."""

import io
import zipfile
from collections.abc import Callable, Mapping
from ctypes import CFUNCTYPE, c_double, c_int, c_size_t, c_uint32, c_void_p
from functools import partial
from importlib.metadata import version
from math import inf
from types import SimpleNamespace
from typing import Any

import fmpy
from fmpy.model_description import ModelDescription

from maglev.cosim.fmi_versions import OWN_TOOL
from maglev.cosim.fmu import Fmu
from maglev.cosim.port_map import Scale
from maglev.files.errors import ControllerError, FmuError
from maglev.files.session import SESSION
from maglev.files.worker_process import Served
from maglev.fmi.build import build_date
from maglev.fmi.declaration import WrittenDefinition
from maglev.fmi.model_description import model_description
from maglev.fmi.slave import Refused
from maglev.fmi.trouble import error_text
from maglev.fmi.user_slave import WrittenSlave
from maglev.language.errors import ExportError
from maglev.user.source import FmuFile, PythonClass, PythonFile, Source, folder_first

TOOL = "Python class"   # instead of the tool that makes FMUs, in generationTool
OK, ERROR = 0, 3        # fmi2OK, fmi2Error
ACCESS = CFUNCTYPE(c_uint32, c_void_p, c_void_p, c_size_t, c_void_p)   # fmi2GetReal and its like
STEP = CFUNCTYPE(c_uint32, c_void_p, c_double, c_double, c_int)        # fmi2DoStep
END = CFUNCTYPE(c_uint32, c_void_p)                                    # fmi2Terminate
C_TYPES: dict[str, Any] = {"Real": c_double, "Boolean": c_int}


def description_text(source: PythonFile | PythonClass) -> bytes:
    """Model description of a user's class, the same as in its FMU; errors as in `load`."""
    written = source.load()
    guid = written.sha256[0][1][:32] if written.sha256 else ""
    try:
        date = build_date()
    except ExportError as error:
        raise ControllerError(str(error)) from None
    return model_description(written.definition, f"{{{guid}}}", version("maglev-fmus"), date)


def written_description(text: bytes) -> ModelDescription:
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as fmu:
        fmu.writestr("modelDescription.xml", text)
    description = fmpy.read_model_description(archive)
    description.generationTool = f"{OWN_TOOL} {version('maglev-fmus')}, {TOOL}"
    return description


class InProcess(WrittenSlave):
    """The slave without pythonfmu's binary around it."""

    def refused(self, message: str) -> Refused:
        return Refused(message)


class InProcessFmu(Fmu):
    """A slave in Python with the face of an FMU."""

    def __init__(self, name: str, source: Source, description: ModelDescription, scales: Mapping[str, Scale],
                 slave: Any = None):
        self.slave = slave
        super().__init__(name, source, description, scales)

    def load(self) -> None:
        self.raised: BaseException | None = None
        self.instance = SimpleNamespace(   # the part of fmpy's object of an FMU that `Fmu` calls
            component=1, freeInstance=lambda: None,
            setupExperiment=lambda startTime, stopTime: self.slave.setup_experiment(
                startTime, stopTime if stopTime < inf else None),
            enterInitializationMode=self.slave.enter_initialization_mode,
            exitInitializationMode=self.slave.exit_initialization_mode,
            getFMUState=lambda: self.slave._get_fmu_state(),
            setFMUState=lambda state: self.slave._set_fmu_state(state))
        for kind in ("Real", "Boolean"):
            self.get_functions[kind] = ACCESS(partial(self.guarded, self.given, kind))
            self.set_functions[kind] = ACCESS(partial(self.guarded, self.taken, kind))
        self.do_step = STEP(partial(self.guarded, lambda _, time, step, _no_return: self.slave.do_step(time, step)))
        self.terminate = END(partial(self.guarded, lambda _component: self.slave.terminate()))

    def guarded(self, function: Callable[..., None], *arguments: Any) -> int:
        """Status of a call: nothing that is raised gets out of a C function."""
        try:
            function(*arguments)
        except BaseException as error:
            self.raised = error
            self.messages.add(str(error) if isinstance(error, Refused) else self.words(error))
            return ERROR
        return OK

    def words(self, error: BaseException) -> str:
        return str(error)

    def given(self, kind: str, _component: int, references: int, count: int, values: int) -> None:
        get = self.slave.get_real if kind == "Real" else self.slave.get_boolean
        names = list((c_uint32 * count).from_address(references))
        (C_TYPES[kind] * count).from_address(values)[:] = get(names)

    def taken(self, kind: str, _component: int, references: int, count: int, values: int) -> None:
        names, numbers = list((c_uint32 * count).from_address(references)), (C_TYPES[kind] * count).from_address(values)
        if kind == "Real":
            self.slave.set_real(names, list(numbers))
        else:
            self.slave.set_boolean(names, [bool(value) for value in numbers])

    def failed(self, call: str, status: int) -> FmuError:
        # A process of its own gets no Ctrl-C: the class has raised it.
        if isinstance(self.raised, KeyboardInterrupt) and not SESSION.get(Served).third_party:
            raise self.raised
        error = FmuError(f"{self.name} ({self.source.name}): {self.said() or call}")
        error.__cause__ = self.raised
        return error


class WrittenController(InProcessFmu):
    """A user's class with the face of an FMU; errors that it raises end the run with their file and line."""

    def load(self) -> None:
        assert not isinstance(self.source, FmuFile)
        written = self.source.load()
        self.definition: WrittenDefinition = written.definition
        with folder_first(written.file.absolute().parent if written.file is not None else self.folder):
            self.slave = InProcess(self.definition, instance_name=self.key.decode())
        super().load()

    def words(self, error: BaseException) -> str:
        return error_text(error, self.slave.written)
