"""Any block of a stage, whose axes, motors and constants are called as its description calls them."""

from typing import Any

from named_controllers import Adaptive, Controller, Rows
from named_stage import NamedStage

from controller_fmu.adaptive_regulator import AdaptiveRegulator
from controller_fmu.estimator import Estimator
from controller_fmu.pid import PID
from controller_fmu.regulator import Regulator
from maglev.closed_loop.closed_loop import AdaptiveLoop, ClosedLoop
from maglev.descriptions.registry import definitions, known_stages
from plant_fmu.stage import Stage
from pmlsm.stage_description import StageDescription


class NamedLoop:
    """A closed loop whose parts are named."""

    def __init__(self, loop: Any, stage: StageDescription):
        self.controller, self.plant = named(loop.controller, stage), named(loop.plant, stage)
        self.start, self.step = loop.start, loop.step


def named(block: Any, stage: StageDescription) -> Any:
    """A block with names; one of another kind as it is."""
    kinds: dict[type, Any] = {ClosedLoop: NamedLoop, AdaptiveLoop: NamedLoop, Regulator: Controller, PID: Controller,
                              Estimator: Rows}
    if isinstance(block, Stage):
        return NamedStage(stage, block)
    if isinstance(block, AdaptiveRegulator):
        return Adaptive(stage, block)
    return kinds[type(block)](block, stage) if type(block) in kinds else block


def named_block(name: str) -> Any:
    """A new block of an FMU, with names."""
    stage = next(stage for stage in known_stages().stages.values() if name in definitions(stage))
    return named(known_stages().definition(name).new_block(), stage)
