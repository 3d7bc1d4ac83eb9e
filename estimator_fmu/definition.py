"""The FMU of the estimator of a rig."""

from estimator_fmu.variables import estimator_variables, refusals
from fmi_export.definition import Drawing, Experiment, FmuDefinition
from pmlsm.rig import Rig


def estimator(rig: Rig, block: type) -> FmuDefinition:
    """Definition of the estimator of a rig."""
    rows = f"rows_{'tilts' if rig.rotations else rig.name}.html"
    return FmuDefinition(
        name=f"Estimator{rig.suffix}",
        block=block,
        description=f"Estimator of the constants of the {rig.title} while it moves",
        variables=estimator_variables(rig),
        refusals=refusals(rig),
        experiment=Experiment(stop_time=500 * rig.sample_time, step=rig.sample_time),
        variable_step=False,
        sampled=True,
        documentation=(("estimator_fmu", "estimator.html"), ("estimator_fmu", rows),
                       ("estimator_fmu", "matched_filter.html"), ("pmlsm", "motor.html")),
        icon=Drawing("estimator_fmu.drawings", "icon", (len(rig.axes),)),
        sketch=Drawing("estimator_fmu.drawings", "block_diagram"))
