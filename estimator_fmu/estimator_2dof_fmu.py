"""The FMU Estimator2DOF."""

from estimator_fmu.estimator_2dof import STEP_MISFIT, Estimator2DOF
from estimator_fmu.variables import REFUSED_STEP, estimator_variables
from fmi_export.definition import Drawing, Experiment, FmuDefinition
from pmlsm.rigs import RIG_2DOF

ESTIMATOR_2DOF = FmuDefinition(
    name="Estimator2DOF",
    block=Estimator2DOF,
    description="Estimator of the constants of the 2-DOF stage while it moves",
    variables=estimator_variables(RIG_2DOF, "assumed: half of Table 4.3, so that it has to be left",
                                  (1e-4, 1e-6, 1e-4, 1e-2)),
    refusals={STEP_MISFIT: REFUSED_STEP},
    experiment=Experiment(stop_time=0.25, step=RIG_2DOF.sample_time),
    variable_step=False,
    documentation=(("estimator_fmu", "estimator.html"), ("estimator_fmu", "rows_2dof.html"),
                   ("estimator_fmu", "matched_filter.html"), ("pmlsm", "motor.html")),
    icon=Drawing("estimator_fmu.drawings", "icon", (2,)),
    sketch=Drawing("estimator_fmu.drawings", "block_diagram"))
