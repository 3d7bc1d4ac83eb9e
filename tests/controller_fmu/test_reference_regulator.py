"""The regulators against the laws written again from the page, sample by sample over a run with steps."""

import numpy as np
import pytest
from direct_loop import LAYOUTS
from named_controllers import Regulator2DOF, Regulator3DOF
from named_stage import Stage2DOF, Stage3DOF
from reference_stage import TAU, G, shape_functions
from scipy.linalg import expm

OMEGA0, T1, T2 = 1.5 * np.pi, 1e-3, 1e-3

GAINS = {2: [[-1662, -65, -360360, -103350, -20332], [-1182, -55, -154440, -45128, -11924]],
         3: [[-1274, -104, -50001, -3936, -7774], [-463, -35, -15121, -997, -2548], [-463, -35, -15121, -997, -2548]]}
CONSTANTS = {2: (14.20, 796.99, 31.04, 0.07), 3: (0.6135, 0.8224, 327.50, 8.48, 0.0070)}
ANTIWINDUP = {2: (0.0, 0.0), 3: (1e-5, 1.1e-4, 1.25e-4)}
LIMIT = 4.0


class ReferenceRegulator:
    """Nonlinear regulator in matrices: (4.12) or (5.7), (4.15), (4.16), (5.13)."""

    def __init__(self, stage: int, ts: float):
        self.stage, self.ts = stage, ts
        self.gains = np.array(GAINS[stage], dtype=float)
        block = np.zeros((4, 4))
        block[:3, :3] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -OMEGA0**2, 0.0]]
        block[2, 3] = 1.0
        step = expm(block * ts)
        self.phi, self.gamma = step[:3, :3], step[:3, 3]
        self.xi: np.ndarray | None = None

    def sample(self, measured: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """i_d, i_q of each motor, then its phase commands, shape (motors, 5)."""
        e = measured - reference
        k = self.gains
        if self.xi is None:
            self.low, self.velocity = measured.copy(), np.zeros(len(measured))
            self.xi = np.zeros((len(measured), 3))
            self.xi[:, 0] = -k[:, 0] * e / (k[:, 2] + 1)
        before = self.low
        self.low = measured + (before - measured) * np.exp(-self.ts / T1)
        rate = (self.low - before) / self.ts
        self.velocity = rate + (self.velocity - rate) * np.exp(-self.ts / T2)
        v = k[:, 0] * e + k[:, 1] * self.velocity + np.sum(k[:, 2:] * self.xi, axis=1) + self.xi[:, 0]
        f1, f2, f3, f4 = shape_functions(measured[0])
        c = CONSTANTS[self.stage]
        if self.stage == 2:
            i_q = np.array([-v[1] / (c[0] * f1)])
            polynomial = [-c[3] * f4, c[2] * f3, G - c[1] * f2 - c[3] * f4 * i_q[0]**2 - v[0]]
        else:
            i_q = np.array([-v[1] / (2 * c[0] * f1), -v[2] / (2 * c[1] * f1)])
            polynomial = [-4 * c[4] * f4, 4 * c[3] * f3,
                          G - 4 * c[2] * f2 - 2 * c[4] * f4 * np.sum(i_q**2) - v[0]]
        i_d = np.roots(polynomial).real.min()
        u = np.array([i_d, *i_q])
        limited = np.clip(u, -LIMIT, LIMIT)
        ec = np.array(ANTIWINDUP[self.stage])
        self.xi = (self.xi @ self.phi.T + np.outer(e, self.gamma)
                   + self.ts * np.outer(ec * (limited - u), np.ones(3)))
        rows = []
        for i, displacement in zip(limited[1:], measured[1:], strict=True):
            angles = np.pi / TAU * (displacement - TAU / 2) + np.array([0, -2 * np.pi / 3, 2 * np.pi / 3])
            rows.append([limited[0], i, *(np.cos(angles) * limited[0] - np.sin(angles) * i)])
        return np.array(rows)


@pytest.mark.parametrize("description", [pytest.param(2, marks=pytest.mark.thorough), 3])
@pytest.mark.usefixtures("slow")
def test_every_command_of_a_run(description: int) -> None:
    """Steps on all axes that saturate the commands; same measurements to both, 0.7 s."""
    axes, motors, dt = LAYOUTS[description]
    controller, stage = (Regulator2DOF(), Stage2DOF()) if description == 2 else (Regulator3DOF(), Stage3DOF())
    controller.start()
    stage.start()
    law = ReferenceRegulator(description, dt)
    first = np.array([getattr(stage, name).encoder for name in axes])
    jump = np.array([3e-3, 25e-3, -25e-3])[:len(axes)]
    worst, saturated = 0.0, 0
    for k in range(round(0.7 / dt)):
        reference = first + 0.4e-3 + (jump if k * dt >= 0.2 else 0.0)
        measured = np.array([getattr(stage, name).encoder for name in axes])
        for name, r, m in zip(axes, reference, measured, strict=True):
            axis = getattr(controller, name)
            axis.reference, axis.measured = float(r), float(m)
        controller.step(k * dt, dt)
        expected = law.sample(measured, reference)
        for name, row in zip(motors, expected, strict=True):
            to, source = getattr(stage, name), getattr(controller, name)
            to.i_a_cmd, to.i_b_cmd, to.i_c_cmd = source.i_a_cmd, source.i_b_cmd, source.i_c_cmd
            ours = (source.i_d_cmd, source.i_q_cmd, source.i_a_cmd, source.i_b_cmd, source.i_c_cmd)
            worst = max(worst, float(np.abs(np.array(ours) - row).max()))
        assert controller.feasible
        saturated += controller.saturated
        stage.step(k * dt, dt)
    assert saturated > 10, "the limit and the antiwindup have to take part"
    assert worst < 1e-7
