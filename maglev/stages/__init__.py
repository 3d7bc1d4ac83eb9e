"""The stages that FMUs are of: those of this project, and those of the user's that this process knows."""

import sys
from collections.abc import Iterable, Sequence
from importlib import import_module
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from fmi_export.definition import FmuDefinition
from pmlsm.rig import Rig
from pmlsm.rigs import RIGS


class OwnStage(NamedTuple):
    """A stage of the user's: its description, the folder with the modules that are written from it, and its file."""

    rig: Rig
    folder: Path
    file: Path


class Stages(MetaPathFinder):
    """The stages that a process knows by their names, the user's from `add` to `forget`.

    Modules written of a user's stage have the names that those of ours have, such as `plant_fmu.plant_mine`: by these
    they import each other, FMUs carry them and C is made of them. So Python has to find them in the stage's folder, and
    this object is what tells it, asked after all others. For the same reason there is one in a process, `STAGES`:
    Python has but one table of modules, too.
    """

    def __init__(self) -> None:
        self.own: dict[str, OwnStage] = {}
        sys.meta_path.append(self)

    def find_spec(self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None,
                  /) -> ModuleSpec | None:
        """Where Python finds a module that is written of a stage of the user's; None of any other module."""
        place = f"{fullname.replace('.', '/')}.py"
        files = (stage.folder / place for stage in self.own.values())
        return next((spec_from_file_location(fullname, file) for file in files if file.is_file()), None)

    def add(self, stage: OwnStage) -> None:
        """Know a stage, in place of one of that name."""
        self.forget(stage.rig.name)
        self.own[stage.rig.name] = stage

    def forget(self, *names: str) -> None:
        """Take back what is known and was imported of stages of the user's; of others nothing is."""
        for name in names:
            if (stage := self.own.pop(name, None)) is not None:
                for path in stage.folder.glob("*/*.py"):
                    sys.modules.pop(f"{path.parent.name}.{path.stem}", None)

    @property
    def rigs(self) -> dict[str, Rig]:
        """Rigs by name, ours first."""
        return RIGS | {name: stage.rig for name, stage in self.own.items()}

    def own_of(self, name: str) -> OwnStage | None:
        """The stage of the user's that an FMU or a system is of, if it is of one."""
        return next((own for own in self.own.values() if name in (*definitions(own.rig), system_of(own.rig))), None)

    def places(self) -> dict[str, tuple[str, str]]:
        """Module and attribute of every FMU that can be built, by its name."""
        return places_of(self.rigs.values())

    def definition(self, name: str) -> FmuDefinition:
        """Definition of an FMU by its name; KeyError if there is none."""
        module, attribute = self.places()[name]
        found: FmuDefinition = getattr(import_module(module), attribute)
        return found

    def systems(self) -> dict[str, Rig]:
        """Rig of every system that can be built, by its name."""
        return {system_of(rig): rig for rig in self.rigs.values() if rig.experiment or rig.name in self.own}


def definitions(rig: Rig) -> dict[str, tuple[str, str]]:
    """Module and attribute of every FMU of a rig, by its name."""
    name, suffix = rig.name, rig.suffix
    designed = {"Scheduled": rig.design.schedule, "Interpolated": rig.design.table}
    laws = ("", "Linear", *(law for law, design in designed.items() if design is not None))
    regulators, loops = f"controller_fmu.regulator_{name}_fmu", f"closed_loop_fmu.closed_loop_{name}_fmu"
    return {
        f"Plant{suffix}": (f"plant_fmu.plant_{name}", "PLANT"),
        **{f"{law}Regulator{suffix}": (regulators, f"{law}_regulator".strip("_").upper()) for law in laws},
        f"PID{suffix}": (f"controller_fmu.pid_{name}_fmu", "PID"),
        f"Commutation{suffix}": (f"controller_fmu.commutation_{name}_fmu", "COMMUTATION"),
        f"Estimator{suffix}": (f"estimator_fmu.estimator_{name}_fmu", "ESTIMATOR"),
        f"AdaptiveRegulator{suffix}": (f"estimator_fmu.adaptive_regulator_{name}_fmu", "ADAPTIVE_REGULATOR"),
        f"Measurement{suffix}": (f"measurement_fmu.measurement_{name}_fmu", "MEASUREMENT"),
        **{f"ClosedLoop{law}{suffix}": (loops, f"CLOSED_LOOP_{law or 'nonlinear'}".upper()) for law in laws},
        f"ClosedLoopPID{suffix}": (loops, "CLOSED_LOOP_PID")}


def places_of(rigs: Iterable[Rig]) -> dict[str, tuple[str, str]]:
    """Module and attribute of every FMU of rigs, by its name."""
    return {name: place for rig in rigs for name, place in definitions(rig).items()}


def system_of(rig: Rig) -> str:
    """Name of the system of a rig: controller and plant as an SSP file."""
    return f"Stage{rig.suffix}"


STAGES = Stages()
