"""Magnetically levitated stages as FMUs: build the FMUs, run the scenarios, judge, compare.

>>> import maglev
>>> run = maglev.run("3dof-smooth-nonlinear")
>>> gap = run["plant.y.position"]        # numpy, SI

Each function does the same as the command of its name.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from maglev.files.errors import (
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
from maglev.files.packages import require_own_packages

if TYPE_CHECKING:
    from maglev.analysis.frequency_response import frequency_response
    from maglev.analysis.numerical import NumericalLoop, linearise_numerically
    from maglev.analysis.region import region
    from maglev.analysis.region_result import Region
    from maglev.analysis.response import FrequencyResponse
    from maglev.api.batch import Batch, BatchInterrupted, batch
    from maglev.api.catalogue import build, fmus, scenarios
    from maglev.api.checking import check, update
    from maglev.api.comparing import Comparison, compare
    from maglev.api.identifying import identify, write_identification
    from maglev.api.repository import new_repository
    from maglev.api.run import Run
    from maglev.api.running import Results, run, run_all
    from maglev.api.studying import Study, new_study, study
    from maglev.api.target import Target, target
    from maglev.api.tuning import Tuned, new_tuning, tune
    from maglev.cosim.master import FmuSetup, Master, RunFailed
    from maglev.linear.linearise import linearise
    from maglev.linear.loop import linearise_loop
    from maglev.pages.live_page import write_live
    from maglev.runs.experiment_check import check_fmus
    from maglev.runs.experiment_pack import pack_reference
    from maglev.user.adoption import know_stage
    from maglev.user.consequences import Consequences, stage
    from maglev.user.new_controller import new_controller, new_plant
    from maglev.user.new_stage import new_scenario, new_stage

# Whoever needs one function does not wait for the imports of all.
PLACES = {name: module for module, names in {
    "maglev.analysis.frequency_response": "frequency_response",
    "maglev.analysis.numerical": "NumericalLoop linearise_numerically", "maglev.analysis.response": "FrequencyResponse",
    "maglev.api.catalogue": "build fmus scenarios", "maglev.api.checking": "check update",
    "maglev.api.comparing": "Comparison compare", "maglev.api.run": "Run",
    "maglev.api.identifying": "identify write_identification", "maglev.api.batch": "Batch BatchInterrupted batch",
    "maglev.api.studying": "Study new_study study", "maglev.api.tuning": "Tuned new_tuning tune",
    "maglev.api.repository": "new_repository", "maglev.api.running": "Results run run_all",
    "maglev.cosim.master": "FmuSetup Master RunFailed", "maglev.runs.experiment_check": "check_fmus",
    "maglev.runs.experiment_pack": "pack_reference", "maglev.linear.linearise": "linearise",
    "maglev.linear.loop": "linearise_loop", "maglev.pages.live_page": "write_live",
    "maglev.api.target": "Target target", "maglev.user.adoption": "know_stage",
    "maglev.user.consequences": "Consequences stage", "maglev.user.new_stage": "new_scenario new_stage",
    "maglev.analysis.region": "region", "maglev.analysis.region_result": "Region",
    "maglev.user.new_controller": "new_controller new_plant"}.items() for name in names.split()}

__all__ = [
    "BaselineError", "Batch", "BatchInterrupted", "BuildError", "Comparison", "Consequences", "ControllerError",
    "CsvError", "FmuError", "FmuSetup", "FrequencyResponse", "IdentificationError", "LinearModelError", "MaglevError",
    "Master", "MeasurementError", "NumericalLoop", "QuantityError", "Region", "Results", "Run", "RunFailed",
    "ScenarioError", "StabilityError", "Study", "Target", "Tuned", "UnknownName", "batch", "build", "check",
    "check_fmus", "compare", "fmus", "frequency_response", "identify", "know_stage", "linearise", "linearise_loop",
    "linearise_numerically",
    "new_controller", "new_plant", "new_repository", "new_scenario", "new_stage", "new_study", "new_tuning",
    "pack_reference",
    "region", "run", "run_all", "scenarios", "stage", "study", "target", "tune", "update",
    "write_identification", "write_live"]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("maglev-fmus")
    if name not in PLACES:
        raise AttributeError(f"module 'maglev' has no attribute {name!r}")
    require_own_packages()
    return getattr(import_module(PLACES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)   # what is for users, and not what their imports have brought in
