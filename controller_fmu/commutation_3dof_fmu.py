"""The FMU Commutation3DOF."""

from controller_fmu.commutation_3dof import Commutation3DOF
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
from pmlsm.data_sheet import SAMPLE_TIME_3DOF

COMMUTATION_3DOF = FmuDefinition(
    name="Commutation3DOF",
    block=Commutation3DOF,
    description="Commutation of the 3-DOF stage's motor pairs, for direct and quadrature currents that are inputs",
    variables=(
        measured_axis("x", "horizontal displacement along x"),
        measured_axis("z", "horizontal displacement along z"),
        *current_references("alpha"),
        *current_references("beta"),
        *commutated_outputs("alpha", "x.measured"),
        *commutated_outputs("beta", "z.measured"),
        reference_limited("alpha", "beta"),
        *sampling_and_limit("stated, section 5.1.4", "assumed: none, the amplifiers have their own")),
    refusals={STEP_MISFIT: REFUSED_STEP},
    experiment=Experiment(stop_time=0.1, step=SAMPLE_TIME_3DOF),
    variable_step=False,
    documentation=(("controller_fmu", "commutation.html"), ("pmlsm", "motor.html")),
    icon=CONTROLLER_ICON)
