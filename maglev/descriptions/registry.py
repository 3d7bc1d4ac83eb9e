"""The stages of FMUs: those of this project, and the user's stages that this process knows."""

from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.session import SESSION
from maglev.fmi.definition import FmuDefinition
from pmlsm.description_text import from_text, to_text
from pmlsm.stage_description import StageDescription

LOOP = "maglev.closed_loop.definition.closed_loop"


class OwnStage(NamedTuple):
    """A user's stage: its description, the folder with the pages that are written from it, and its file."""

    description: StageDescription
    folder: Path
    file: Path


class Stages:
    """The stages that a process knows by their names, the user's from `add` to `forget`."""

    def __init__(self) -> None:
        self.own: dict[str, OwnStage] = {}
        self.made: dict[str, FmuDefinition] = {}

    def add(self, stage: OwnStage) -> None:
        """Add a stage, or replace the one of that name."""
        self.forget(stage.description.name)
        self.own[stage.description.name] = stage

    def forget(self, *names: str) -> None:
        """Forget the stages of the user; those of this project stay."""
        for name in names:
            if (stage := self.own.pop(name, None)) is not None:
                self.made = {fmu: made for fmu, made in self.made.items() if fmu not in definitions(stage.description)}

    @property
    def stages(self) -> dict[str, StageDescription]:
        """Stages by name, the packaged ones first."""
        return PACKAGED_STAGES | {name: stage.description for name, stage in self.own.items()}

    def own_of(self, name: str) -> OwnStage | None:
        """Return the user's stage of an FMU or a system, or None."""
        return next((own for own in self.own.values()
                     if name in (*definitions(own.description), system_of(own.description))), None)

    def definitions(self) -> dict[str, "Made"]:
        """Return the recipe of the definition of every FMU that can be built, by its name."""
        return definitions_of(self.stages.values())

    def definition(self, name: str) -> FmuDefinition:
        """Definition of an FMU by its name; KeyError if there is none."""
        if name not in self.made:
            self.made[name] = self.definitions()[name].value()
        return self.made[name]

    def systems(self) -> dict[str, StageDescription]:
        """Stage of every system that can be built, by its name."""
        return {system_of(stage): stage for stage in self.stages.values() if stage.experiment or stage.name in self.own}


class Made(NamedTuple):
    """Recipe of a definition: a function, a description, and further arguments, by import paths or further recipes."""

    function: str   # as "plant_fmu.definition.plant"
    description: StageDescription
    arguments: tuple["str | Made", ...]

    def value(self) -> Any:
        return imported(self.function)(self.description, *(
            argument.value() if isinstance(argument, Made) else imported(argument) for argument in self.arguments))

    def text(self) -> str:
        """Return the recipe as Python, which an FMU runs to make its DEFINITION."""
        paths = {*self.paths(), f"{from_text.__module__}.{from_text.__name__}"}
        imports = sorted("from {} import {}\n".format(*path.rsplit(".", 1)) for path in paths)
        lines = (f"    {line!r}\n" for line in to_text(self.description).splitlines(keepends=True))
        return f"{''.join(imports)}\nSTAGE = from_text(\n{''.join(lines)})\n\nDEFINITION = {self.call()}\n"

    def call(self) -> str:
        arguments = (argument.call() if isinstance(argument, Made) else last(argument) for argument in self.arguments)
        return f"{last(self.function)}({', '.join(('STAGE', *arguments))})"

    def paths(self) -> list[str]:
        """Return the import paths of everything that the recipe uses."""
        return [self.function, *(path for argument in self.arguments for path in (
            argument.paths() if isinstance(argument, Made) else [argument]))]


def last(path: str) -> str:
    """Last name in a path, as "plant" of "plant_fmu.definition.plant"."""
    return path.rpartition(".")[2]


def imported(path: str) -> Any:
    return getattr(import_module(path.rpartition(".")[0]), last(path))


def definitions(stage: StageDescription) -> dict[str, Made]:
    """Return the recipe of the definition of every FMU of a stage, by its name."""
    suffix = stage.suffix

    def described(function: str, *arguments: str | Made) -> Made:
        return Made(function, stage, arguments)

    designed = {"Scheduled": stage.design.schedule, "Interpolated": stage.design.table}
    laws = ("", "Linear", *(law for law, design in designed.items() if design is not None))
    regulators = {law: described("controller_fmu.definitions.regulator",
                                 f"controller_fmu.status.{law.upper() or 'NONLINEAR'}") for law in laws}
    plant = described("plant_fmu.definition.plant")
    pid = described("controller_fmu.definitions.pid")
    estimator = described("controller_fmu.estimator_definitions.estimator")
    adaptive = described("controller_fmu.estimator_definitions.adaptive_regulator", regulators[""], estimator)
    loops = {**regulators, "PID": pid, "Adaptive": adaptive}
    return {
        f"Plant{suffix}": plant,
        **{f"{law}Regulator{suffix}": regulator for law, regulator in regulators.items()},
        f"PID{suffix}": pid,
        f"Commutation{suffix}": described("controller_fmu.definitions.commutation"),
        f"Estimator{suffix}": estimator,
        f"AdaptiveRegulator{suffix}": adaptive,
        f"Measurement{suffix}": described("controller_fmu.measurement_definition.measurement"),
        **{f"ClosedLoop{word}{suffix}": described(LOOP, controller, plant) for word, controller in loops.items()}}


def definitions_of(stages: Iterable[StageDescription]) -> dict[str, Made]:
    """Return the recipe of the definition of every FMU of some stages, by its name."""
    return {name: made for stage in stages for name, made in definitions(stage).items()}


def system_of(stage: StageDescription) -> str:
    """Name of the system of a stage: controller and plant as an SSP file."""
    return f"Stage{stage.suffix}"


def known_stages() -> Stages:
    """Return the stages that this process knows."""
    return SESSION.get(Stages)
