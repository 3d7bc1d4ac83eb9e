"""Plan the fastest motion of the 3-DOF stage, and the one of least energy, with CasADi and the plant's FMU.

    maglev build --kind native --target host Plant3DOF
    python examples/optimal_motion/plan.py              # writes fastest.csv and thrifty.csv next to this file
    python examples/optimal_motion/run.py               # runs them under the thesis's regulator: table and picture

The mover goes from rest to rest over the first step of the setpoints: gap 25 to 27 mm, x 0 to 10 mm, z 0 to -15 mm.
CasADi imports the FMU for model exchange and uses its derivatives. The unknowns are positions, velocities, and the
currents i_d, i_q of the motors, constant in each interval (direct collocation, Radau, degree 3). Each phase has at most
4 A. Two effects of the plant are left to the regulator: the lag of the amplifiers, 0.3 ms, which is short compared with
an interval, and presliding friction, which has a kink when the mover turns.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import casadi as ca
import fmpy
import numpy as np
from scipy.integrate import solve_ivp

from pmlsm.motor_geometry import MotorGeometry

AXES, MOTORS, PHASES = "yxz", ("alpha", "beta"), "abc"
CURRENTS = tuple(f"{motor}.i_{part}" for motor in MOTORS for part in "dq")
START = np.array([25e-3, 0.0, 0.0])       # m
TARGET = np.array([27e-3, 10e-3, -15e-3])
GAPS = 20e-3, 30e-3       # m, between which the mover stays
LIMIT = 4.0               # A, of each phase
RESISTANCE = 3.5          # ohm, of a phase, as of the plant
DURATION = 0.6            # s, of the motion that takes the least energy
INTERVALS = 160
BEGIN = 0.2               # s, at which the motion begins in a file
ROW = 2e-3                # s, at most between rows of a file, between which references are interpolated
METRE, SPEED = 1e3, 10.0  # unknowns are in mm and dm/s: all of a size


class Stage:
    """The plant from its FMU, which lies unpacked in a folder, as functions of positions, velocities and currents."""

    def __init__(self, folder: Path):
        stage = ca.DaeBuilder("stage", str(folder))
        for axis in AXES:
            stage.set(f"{axis}.friction.coulomb", 0.0)
        rates = stage.create("rates", ["x", "u"], ["ode"])
        q, v, i = ca.MX.sym("q", 3), ca.MX.sym("v", 3), ca.MX.sym("i", 4)
        phases = [*self.phases(i[0], i[1], q[1]), *self.phases(i[2], i[3], q[2])]   # alpha drives x, beta z
        known = {f"{motor}.i_{phase}": phases[3 * m + p] for m, motor in enumerate(MOTORS)
                 for p, phase in enumerate(PHASES)}
        for k, axis in enumerate(AXES):
            known |= {f"{axis}.position": q[k], f"{axis}.velocity": v[k]}
        names = stage.x()
        slopes = rates(ca.vertcat(*(known.get(name, 0.0) for name in names)), np.zeros(stage.nu()))
        accelerations = ca.vertcat(*(slopes[names.index(f"{axis}.velocity")] for axis in AXES))
        self.at = ca.Function("at", [q, v, i], [accelerations, ca.vertcat(*phases)])

    @staticmethod
    def phases(i_d: ca.MX, i_q: ca.MX, displacement: ca.MX) -> list[ca.MX]:
        """Phase currents by the commutation (C.1)."""
        theta = MotorGeometry().electrical_angle(displacement)
        return [ca.cos(theta - turn) * i_d - ca.sin(theta - turn) * i_q
                for turn in (0.0, 2.0 * np.pi / 3.0, -2.0 * np.pi / 3.0)]


@dataclass(frozen=True)
class Plan:
    """A motion: duration (s), energy (J), currents (A) of each interval and states (m, m/s) before and after it."""

    duration: float
    energy: float
    currents: np.ndarray   # a column for each interval
    states: np.ndarray     # and one more


def energy(currents: ca.MX, interval: ca.MX) -> ca.MX:
    """Return the loss in the windings (J): the squares of three phases are 3/2 of those of i_d and i_q."""
    return RESISTANCE * 1.5 * ca.sumsqr(currents) * interval


def planned(stage: Stage, duration: float | None = None, intervals: int = INTERVALS) -> Plan:
    """The motion of least energy in a duration (s), or the fastest one."""
    points = ca.collocation_points(3, "radau")
    slopes, ends, _ = ca.collocation_coeff(points)
    problem = ca.Opti()
    span = problem.variable() if duration is None else duration
    guess = duration or 0.25
    if duration is None:
        problem.subject_to(problem.bounded(0.05, span, 2.0))
        problem.set_initial(span, guess)
    q, v = problem.variable(3, intervals + 1), problem.variable(3, intervals + 1)
    i = problem.variable(4, intervals)
    problem.set_initial(i, np.tile([0.6, 0.0], 2)[:, None] * np.ones(intervals))
    inner_q, inner_v, inner_i, rates_v = [], [], [], []
    h = span / intervals
    for k in range(intervals):
        of_q, of_v = problem.variable(3, 3), problem.variable(3, 3)
        along = np.array([k / intervals, *((k + point) / intervals for point in points)])
        way = METRE * (START[:, None] + (TARGET - START)[:, None] * (3.0 - 2.0 * along) * along**2)
        pace = SPEED * (TARGET - START)[:, None] * 6.0 * along * (1.0 - along) / guess
        for unknown, value in ((q[:, k], way[:, 0]), (v[:, k], pace[:, 0]), (of_q, way[:, 1:]), (of_v, pace[:, 1:])):
            problem.set_initial(unknown, value)
        all_q, all_v = ca.horzcat(q[:, k], of_q), ca.horzcat(v[:, k], of_v)
        problem.subject_to(ca.vec(all_q @ slopes - h * METRE / SPEED * of_v) == 0)
        problem.subject_to(all_q @ ends == q[:, k + 1])
        problem.subject_to(all_v @ ends == v[:, k + 1])
        inner_q.append(of_q)
        inner_v.append(of_v)
        inner_i.append(ca.repmat(i[:, k], 1, 3))
        rates_v.append(all_v @ slopes)
    accelerations, phases = stage.at.map(3 * intervals)(
        ca.horzcat(*inner_q) / METRE, ca.horzcat(*inner_v) / SPEED, ca.horzcat(*inner_i))
    problem.subject_to(ca.vec(ca.horzcat(*rates_v) - h * SPEED * accelerations) == 0)
    problem.subject_to(problem.bounded(-LIMIT, ca.vec(phases), LIMIT))
    problem.subject_to(problem.bounded(METRE * GAPS[0], q[0, 1:].T, METRE * GAPS[1]))
    for k, place in ((0, START), (intervals, TARGET)):
        problem.subject_to(q[:, k] == METRE * place)
        problem.subject_to(v[:, k] == 0.0)
    problem.set_initial(q[:, intervals], METRE * TARGET)
    # If x has time to spare, many motions are the fastest: a little weight on the energy selects one.
    problem.minimize(energy(i, h) if duration is not None else span + 1e-5 * energy(i, h))
    problem.solver("ipopt", {"print_time": False}, {"print_level": 0, "sb": "yes", "tol": 1e-8})
    solved = problem.solve()
    return Plan(float(solved.value(span)), float(solved.value(energy(i, h))), solved.value(i),
                solved.value(ca.vertcat(q / METRE, v / SPEED)))


def integrated(stage: Stage, plan: Plan) -> tuple[np.ndarray, np.ndarray]:
    """Rows of time, positions, velocities, currents, by scipy at 1e-10; and how far each interval misses the next one.

    Each interval begins where the plan has it: the stage is unstable, and makes e^27 of a deviation in 0.6 s.
    """
    h = plan.duration / plan.currents.shape[1]
    times = np.linspace(0.0, h, int(np.ceil(h / ROW)) + 1)
    rows, misses = [], []
    for k, currents in enumerate(plan.currents.T):
        def rates(_: float, s: np.ndarray, i: np.ndarray = currents) -> np.ndarray:
            return np.concatenate([s[3:], np.array(stage.at(s[:3], s[3:], i)[0]).ravel()])

        states = solve_ivp(rates, (0.0, h), plan.states[:, k], method="DOP853", rtol=1e-10, atol=1e-12,
                           t_eval=times).y.T
        rows += [[k * h + t, *state, *currents] for t, state in zip(times[:-1], states[:-1], strict=True)]
        misses.append(np.abs(states[-1] - plan.states[:, k + 1]))
    rows.append([plan.duration, *plan.states[:, -1], *plan.currents[:, -1]])
    return np.array(rows), np.array(misses)


def write(rows: np.ndarray, path: Path) -> None:
    """Write a motion as a file that a scenario reads: at rest until it begins, and where it ends."""
    columns = ["time", *AXES, *(f"{axis}.rate" for axis in AXES), *CURRENTS]
    table = np.vstack([[0.0, *START, *np.zeros(7)], np.column_stack([BEGIN + rows[:, 0], rows[:, 1:]])])
    np.savetxt(path, table, "%.9g", ",", header=",".join(columns), comments="")


def main() -> None:
    """Plan both motions, integrate their currents by scipy, and write them."""
    parser = argparse.ArgumentParser(description="plan the fastest motion and the one of least energy")
    parser.add_argument("--fmu", type=Path, default=Path("fmus/native/Plant3DOF.fmu"), help="the plant, FMI 2.0 or 3.0")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent, help="folder of the files")
    parser.add_argument("--intervals", type=int, default=INTERVALS)
    asked = parser.parse_args()
    with TemporaryDirectory() as folder:
        fmpy.extract(str(asked.fmu), folder)
        stage = Stage(Path(folder))
        for name, duration in (("fastest", None), ("thrifty", DURATION)):
            plan = planned(stage, duration, asked.intervals)
            rows, misses = integrated(stage, plan)
            write(rows, asked.out / f"{name}.csv")
            print(f"{name}: {plan.duration:.5f} s, {plan.energy:.4f} J; by scipy each interval ends within "
                  f"{1e9 * misses[:, :3].max():.2g} nm and {1e6 * misses[:, 3:].max():.2g} µm/s of the next")


if __name__ == "__main__":
    main()
