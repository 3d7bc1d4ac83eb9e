"""Ports of a controller of the 3-DOF stage, and its feedback-linearised motors, shared by the examples."""

from controller_fmu.feedback_linearisation import demanded_current
from controller_fmu.motor_command import MotorCommand
from maglev.descriptions.packaged import PACKAGED_STAGES
from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.saturation import saturate
from pmlsm.velocity_rows import normal_acceleration, thrust_term

MOTOR = MotorGeometry()

SAMPLE_TIME = 0.2e-3   # s
LIMIT = 4.0            # A, of i_d and i_q, as of the thesis's regulator (section 5.6.2)

INPUTS = {f"{axis}.{port}": "m" for axis in ("y", "x", "z") for port in ("reference", "measured")}
OUTPUTS = {f"{motor}.i_{current}_cmd": "A" for motor in ("alpha", "beta") for current in ("a", "b", "c", "d", "q")}

KNOWN = PACKAGED_STAGES["3dof"].model   # constants that the thesis's regulator knows, not those of the stage
THRUST_X, THRUST_Z = 2.0 * KNOWN.thrust["x"], 2.0 * KNOWN.thrust["z"]               # m/(s² A)
VERTICAL = (4.0 * KNOWN.attraction, 4.0 * KNOWN.coils, 4.0 * KNOWN.iron)   # of (5.7)


class Axis:
    """Ports of one axis."""

    def __init__(self, position: float):
        self.reference = position       # m, input
        self.measured = position        # m, input


def accelerations(gap: float, i_d: float, i_qa: float, i_qb: float) -> tuple[float, float, float]:
    """Accelerations of y, x, z (m/s²) that currents (A) make at an air gap (m), as the regulator knows the stage."""
    f1, f2, f3, f4 = gap_functions(MOTOR, gap)
    return (normal_acceleration(*VERTICAL, f2, f3, f4, i_d, i_d**2 + 0.5 * (i_qa**2 + i_qb**2)),
            thrust_term(THRUST_X, f1, i_qa), thrust_term(THRUST_Z, f1, i_qb))


def quadrature_currents(gap: float, x: float, z: float) -> tuple[float, float]:
    """Currents i_qα, i_qβ (A), limited, for accelerations of x and z (m/s²) at an air gap (m) (5.7)."""
    thrust, _, _, _ = gap_functions(MOTOR, gap)
    return saturate(-x / (THRUST_X * thrust), LIMIT), saturate(-z / (THRUST_Z * thrust), LIMIT)


def command(alpha: MotorCommand, beta: MotorCommand, demands: tuple[float, float, float], gap: float, x: float,
            z: float) -> tuple[float, float, float]:
    """Command the currents for accelerations of y, x, z (m/s²) at measured positions (m), as far as the limit goes.

    Unlike in (5.7), the direct current compensates the limited quadrature currents. A step of x that asks for 20 A must
    not make the gap compensate 20 A that do not flow. Returns the accelerations by the limited currents, which
    antiwindup and observers need.
    """
    i_qa, i_qb = quadrature_currents(gap, demands[1], demands[2])
    _, f2, f3, f4 = gap_functions(MOTOR, gap)
    i_d, _ = demanded_current(demands[0], 0.5 * VERTICAL[2] * f4 * (i_qa**2 + i_qb**2), *VERTICAL, f2, f3, f4)
    alpha.command(i_d, i_qa, LIMIT, MOTOR.electrical_angle(x))
    beta.command(i_d, i_qb, LIMIT, MOTOR.electrical_angle(z))
    return accelerations(gap, alpha.i_d_cmd, i_qa, i_qb)
