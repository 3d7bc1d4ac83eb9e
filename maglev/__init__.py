"""Magnetically levitated stages as FMUs: build the FMUs, fly the experiments, judge, compare.

>>> import maglev
>>> run = maglev.run("3dof-smooth-nonlinear")
>>> gap = run["plant.y.position"]        # numpy, SI

What the command line `maglev` does, these functions do.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from maglev.errors import (
    BaselineError,
    BuildError,
    ControllerError,
    CsvError,
    FmuError,
    IdentificationError,
    LinearModelError,
    MaglevError,
    MeasurementError,
    QuantityError,
    ScenarioError,
    StabilityError,
    UnknownName,
)
from maglev.packages import require_own_packages

if TYPE_CHECKING:
    from maglev.analysis.frequency_response import frequency_response
    from maglev.analysis.numerical import NumericalLoop, linearise_numerically
    from maglev.analysis.response import FrequencyResponse
    from maglev.api.catalogue import build, fmus, scenarios
    from maglev.api.checking import check, update
    from maglev.api.comparing import Comparison, compare
    from maglev.api.flown import Run
    from maglev.api.identifying import identify, write_identification
    from maglev.api.many.batch import Batch, BatchInterrupted, batch
    from maglev.api.many.studying import Study, study, sweep
    from maglev.api.many.tuning import Tuned, tune
    from maglev.api.repository import new_repository
    from maglev.api.running import Results, run, run_all
    from maglev.cosim.master import FmuSetup, Master, RunFailed
    from maglev.fmu_experiments.check import check_fmus
    from maglev.fmu_experiments.pack import pack_reference
    from maglev.linear.linearise import linearise
    from maglev.linear.loop import linearise_loop
    from maglev.live.page import write_live
    from maglev.microcontroller.target import Target, target
    from maglev.own_stage.adoption import know_stage
    from maglev.own_stage.consequences import Consequences, stage
    from maglev.own_stage.new import new_scenario, new_stage
    from maglev.stability.analysis import region
    from maglev.stability.result import Region
    from maglev.studies.new import new_study
    from maglev.user_controllers.new import new_controller, new_plant

# Whoever needs one function does not wait for the imports of all.
PLACES = {
    "Batch": "maglev.api.many.batch", "BatchInterrupted": "maglev.api.many.batch",
    "batch": "maglev.api.many.batch", "Consequences": "maglev.own_stage.consequences",
    "Comparison": "maglev.api.comparing", "FrequencyResponse": "maglev.analysis.response",
    "NumericalLoop": "maglev.analysis.numerical", "Region": "maglev.stability.result", "Results": "maglev.api.running",
    "Run": "maglev.api.flown", "RunFailed": "maglev.cosim.master", "FmuSetup": "maglev.cosim.master",
    "Master": "maglev.cosim.master", "build": "maglev.api.catalogue",
    "check": "maglev.api.checking", "check_fmus": "maglev.fmu_experiments.check",
    "compare": "maglev.api.comparing", "fmus": "maglev.api.catalogue",
    "frequency_response": "maglev.analysis.frequency_response",
    "identify": "maglev.api.identifying", "linearise": "maglev.linear.linearise",
    "linearise_numerically": "maglev.analysis.numerical",
    "know_stage": "maglev.own_stage.adoption",
    "linearise_loop": "maglev.linear.loop", "new_controller": "maglev.user_controllers.new",
    "new_plant": "maglev.user_controllers.new", "new_repository": "maglev.api.repository",
    "new_scenario": "maglev.own_stage.new", "new_stage": "maglev.own_stage.new",
    "new_study": "maglev.studies.new", "pack_reference": "maglev.fmu_experiments.pack",
    "region": "maglev.stability.analysis", "run": "maglev.api.running",
    "run_all": "maglev.api.running",
    "scenarios": "maglev.api.catalogue", "stage": "maglev.own_stage.consequences",
    "Study": "maglev.api.many.studying", "study": "maglev.api.many.studying",
    "sweep": "maglev.api.many.studying", "Target": "maglev.microcontroller.target",
    "target": "maglev.microcontroller.target", "Tuned": "maglev.api.many.tuning", "tune": "maglev.api.many.tuning",
    "update": "maglev.api.checking",
    "write_identification": "maglev.api.identifying", "write_live": "maglev.live.page"}

__all__ = [
    "BaselineError", "Batch", "BatchInterrupted", "BuildError", "Comparison", "Consequences", "ControllerError",
    "CsvError", "FmuError", "FmuSetup", "FrequencyResponse", "IdentificationError", "LinearModelError", "MaglevError",
    "Master", "MeasurementError", "NumericalLoop", "QuantityError", "Region", "Results", "Run", "RunFailed",
    "ScenarioError", "StabilityError", "Study", "Target", "Tuned", "UnknownName", "batch", "build", "check",
    "check_fmus", "compare", "fmus", "frequency_response", "identify", "know_stage", "linearise", "linearise_loop",
    "linearise_numerically",
    "new_controller", "new_plant", "new_repository", "new_scenario", "new_stage", "new_study", "pack_reference",
    "region", "run", "run_all", "scenarios", "stage", "study", "sweep", "target", "tune", "update",
    "write_identification", "write_live"]


def __getattr__(name: str) -> Any:
    if name not in PLACES:
        raise AttributeError(f"module 'maglev' has no attribute {name!r}")
    require_own_packages()
    return getattr(import_module(PLACES[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *PLACES])
