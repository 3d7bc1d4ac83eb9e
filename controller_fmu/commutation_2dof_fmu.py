"""The FMU Commutation2DOF."""

from controller_fmu.commutation_2dof import Commutation2DOF
from controller_fmu.icon import CONTROLLER_ICON
from controller_fmu.status import STEP_MISFIT
from controller_fmu.variables import (
    REFUSED_STEP,
    commutated_outputs,
    current_references,
    measured_axis,
    reference_limited,
    sampling_and_limit,
)
from fmi_export.definition import Experiment, FmuDefinition
from pmlsm.data_sheet import SAMPLE_TIME_2DOF

COMMUTATION_2DOF = FmuDefinition(
    name="Commutation2DOF",
    block=Commutation2DOF,
    description="Commutation of the 2-DOF stage's motor, for direct and quadrature currents that are inputs",
    variables=(
        measured_axis("h", "horizontal displacement"),
        *current_references("motor"),
        *commutated_outputs("motor", "h.measured"),
        reference_limited("motor"),
        *sampling_and_limit("stated, section 4.1.4", "assumed: none, the amplifiers have their own")),
    refusals={STEP_MISFIT: REFUSED_STEP},
    experiment=Experiment(stop_time=0.2, step=SAMPLE_TIME_2DOF),
    variable_step=False,
    documentation=(("controller_fmu", "commutation.html"), ("pmlsm", "motor.html")),
    icon=CONTROLLER_ICON)
