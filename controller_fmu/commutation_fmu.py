"""The FMUs Commutation2DOF and Commutation3DOF."""

from controller_fmu.commutation_2dof import Commutation2DOF
from controller_fmu.commutation_3dof import Commutation3DOF
from controller_fmu.drawings import DIAGRAMS, ICONS
from controller_fmu.status import STEP_MISFIT
from controller_fmu.variables import REFUSED_STEP, commutation_variables
from fmi_export.definition import Drawing, Experiment, FmuDefinition
from pmlsm.rigs import RIG_2DOF, RIG_3DOF, Rig


def commutation(name: str, block: type, rig: Rig, motors: str, stop_time: float) -> FmuDefinition:
    """Commutation of a rig; its motors in words, and the end of the default experiment (s)."""
    return FmuDefinition(
        name=name,
        block=block,
        description=f"Commutation of the {motors}, for direct and quadrature currents that are inputs",
        variables=commutation_variables(rig),
        refusals={STEP_MISFIT: REFUSED_STEP},
        experiment=Experiment(stop_time=stop_time, step=rig.sample_time),
        variable_step=False,
        documentation=(("controller_fmu", "commutation.html"), ("pmlsm", "motor.html")),
        icon=Drawing(ICONS, "controller", ("commutation", len(rig.axis_names))),
        sketch=Drawing(DIAGRAMS, "commutation"))


COMMUTATION_2DOF = commutation("Commutation2DOF", Commutation2DOF, RIG_2DOF, "2-DOF stage's motor", 0.25)
COMMUTATION_3DOF = commutation("Commutation3DOF", Commutation3DOF, RIG_3DOF, "3-DOF stage's motor pairs", 0.1)
