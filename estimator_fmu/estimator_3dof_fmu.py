"""The FMU Estimator3DOF."""

from estimator_fmu.estimator_3dof import STEP_MISFIT, Estimator3DOF
from estimator_fmu.variables import REFUSED_STEP, estimator_variables
from fmi_export.definition import Drawing, Experiment, FmuDefinition
from pmlsm.rigs import RIG_3DOF

ESTIMATOR_3DOF = FmuDefinition(
    name="Estimator3DOF",
    block=Estimator3DOF,
    description="Estimator of the constants of the 3-DOF stage while it moves",
    variables=estimator_variables(RIG_3DOF, "assumed: half of Table 5.3, so that it has to be left",
                                  (1e-2, 1e-2, 1e-6, 1e-4, 1e-1)),
    refusals={STEP_MISFIT: REFUSED_STEP},
    experiment=Experiment(stop_time=0.1, step=RIG_3DOF.sample_time),
    variable_step=False,
    documentation=(("estimator_fmu", "estimator.html"), ("estimator_fmu", "rows_3dof.html"),
                   ("estimator_fmu", "matched_filter.html"), ("pmlsm", "motor.html")),
    icon=Drawing("estimator_fmu.drawings", "icon", (3,)),
    sketch=Drawing("estimator_fmu.drawings", "block_diagram"))
