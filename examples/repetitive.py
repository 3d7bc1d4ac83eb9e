"""Repetitive learning on top of the thesis's regulator of the 3-DOF stage, for its sinusoids (section 5.6.4).

    maglev run 3dof-tracking-nonlinear --controller examples/repetitive.py
    python examples/repetitive.py        # mean errors of each period, with friction, with noise, without; picture

The regulator's internal model leaves no error at the frequency of the reference. Errors by friction and the ripple of
the guide repeat with the reference, at multiples of its frequency. Harmonics 2 to 20 of the error of one period are
divided by the response of the closed loop. Two periods later they are subtracted from the reference: U ← U − g
E/T̂(jnω0). The period between is skipped, because the loop still settles. E decays if |1 − g T(jnω0)/T̂(jnω0)| < 1, for
any repeating disturbance.
"""

from cmath import rect
from itertools import product
from math import floor, pi
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from stage_3dof import INPUTS, OUTPUTS

import maglev
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.regulator import Regulator
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.linear.loop import linearise_loop

GAINS = {"y": (-1487.0, -140.0, -50001.0, -560.0, -7836.0), "x": (-354.0, -41.0, -8945.0, 1201.0, -1472.0),
         "z": (-354.0, -41.0, -8945.0, 1201.0, -1472.0)}   # (5.12), corrected
LOOP = {**{f"{axis}.k{k}": gain for axis, gains in GAINS.items() for k, gain in enumerate(gains, 1)},
        "current_limit": 1000.0, "antiwindup": False}
KNOWN = {"C3": 327.5, "C4": 8.48, "C5": 0.007}   # constants of the regulator: the stage has others
HARMONICS = range(2, 21)
OMEGA = 1.5 * pi   # rad/s


def loop_at_harmonics(axis: str, gap: float, plant: dict[str, float]) -> np.ndarray:
    """T(jnω0), from a reference of an axis with its rate to the position, at a gap (m) with constants of a plant."""
    closed = linearise_loop("Plant3DOF", "Regulator3DOF", {"y": gap}, plant_parameters=plant,
                            controller_parameters=LOOP).closed
    omega = OMEGA * np.array(HARMONICS)
    both = closed.select((f"{axis}.reference", f"{axis}.reference_rate"), (f"{axis}.position",))
    by_reference, by_rate = both.frequency_response(omega)[:, 0].T
    return by_reference + 1j * omega * by_rate


class Memory:
    """Harmonics of the addition to the reference of one axis, and of its error in the current period."""

    def __init__(self, axis: str):
        self.inverse = 1.0 / loop_at_harmonics(axis, 25e-3, KNOWN)
        self.added = np.zeros(len(HARMONICS), complex)   # m
        self.seen = np.zeros(len(HARMONICS), complex)    # m s

    def correction(self, turns: np.ndarray) -> tuple[float, float]:
        """Return the additions to the reference (m) and to its rate (m/s), for the turned pointers of the harmonics."""
        pointers = self.added * turns
        return float(pointers.real.sum()), float(-OMEGA * (np.array(HARMONICS) * pointers.imag).sum())

    def learn(self, gain: float) -> None:
        """Take a share of the error that was seen in a period out of the reference."""
        self.added -= gain * self.inverse * self.seen * OMEGA / pi


class RepetitiveRegulator(Regulator):
    """The thesis's regulator with its first gains and a memory of the errors of every axis."""

    inputs = {**INPUTS, "y.reference_rate": "m/s", "x.reference_rate": "m/s", "z.reference_rate": "m/s"}
    outputs = {**OUTPUTS, "saturated": "", "feasible": "", "tripped": ""}
    parameters = {"gain": "", "begin": "s"}

    def __init__(self) -> None:
        super().__init__(PACKAGED_STAGES["3dof"])
        self.gain = 0.7     # share learnt from a period; 0 = off
        self.begin = 4.0    # s, of the first period, after the transient of the start
        self.current_limit, self.antiwindup = 0.0, False
        self.axes = [OutputRegulator(*gains, 0.0, 0.025 if axis == "y" else 0.0) for axis, gains in GAINS.items()]
        # By the names of the ports.
        self.y, self.x, self.z = self.axes
        self.alpha, self.beta = self.motors
        self.memories = [Memory(axis) for axis in GAINS]
        self.period = -1

    def step(self, t: float) -> None:
        """Step one sample: the regulator with changed references, then observe and, at the end of a period, learn."""
        period = floor((t - self.begin) * OMEGA / (2.0 * pi) + 1e-9)
        if period != self.period:
            for memory in self.memories:
                if period > 0 and period % 2 == 1:
                    memory.learn(self.gain)
                memory.seen[:] = 0.0
            self.period = period
        turns = np.array([rect(1.0, n * OMEGA * t) for n in HARMONICS])
        axes = (self.y, self.x, self.z)
        given = [(axis.reference, axis.reference_rate) for axis in axes]
        for axis, memory in zip(axes, self.memories, strict=True):
            more, faster = memory.correction(turns)
            memory.seen += (axis.measured - axis.reference) * self.sample_time * turns.conj()
            axis.reference += more
            axis.reference_rate += faster
        self.sample()
        for axis, (reference, rate) in zip(axes, given, strict=True):
            axis.reference, axis.reference_rate = reference, rate


SCENARIOS = Path(maglev.__file__).parents[1] / "scenarios"
REFERENCES = [f"{SCENARIOS}/{name}.toml" for name in ("loops/3dof", "references/3dof-tracking")]
ASSUMED = f"{SCENARIOS}/effects/3dof-as-assumed.toml"
NOISE = {f"measurement.{axis}.noise": "5 um" for axis in GAINS}
ROUGH = {f"plant.{axis}.roughness.rms": rms for axis, rms in (("y", 0.03), ("x", 0.09), ("z", 0.14))}
CASES: dict[str, tuple[list[str], dict[str, float | str]]] = {
    "friction as estimated": (REFERENCES, {}),
    "friction as assumed, twice that": ([*REFERENCES, ASSUMED], {}),
    "and 5 µm of noise": ([*REFERENCES, ASSUMED, f"{SCENARIOS}/loops/3dof-measurement.toml"], NOISE),
    "and rough guides": ([*REFERENCES, ASSUMED], ROUGH)}
PERIODS = 15   # from `begin` on


def mean_errors(layers: list[str], settings: dict[str, float | str]) -> np.ndarray:
    """Mean errors (m) of y, x, z by period, shape (3, PERIODS), of the scenario of some files with settings."""
    last = 4.0 + PERIODS * 2.0 * pi / OMEGA
    run = maglev.run({"extends": layers, "name": "repetitive", "title": "Sinusoids, again and again",
                      "stop_time": last}, controller=RepetitiveRegulator, set=settings, kind="native")
    period = np.floor((run.time - 4.0) * OMEGA / (2.0 * pi) + 1e-9)
    errors = [np.abs(run[f"plant.{axis}.position"] - run[f"controller.{axis}.reference"]) for axis in GAINS]
    return np.array([[error[period == k].mean() for k in range(PERIODS)] for error in errors])


if __name__ == "__main__":
    for axis, gap in product(GAINS, (20e-3, 25e-3, 29.9e-3)):
        stops = {"y.stop.lower": 15e-3, "y.stop.upper": 34e-3}
        ratio = loop_at_harmonics(axis, gap, stops) / loop_at_harmonics(axis, 25e-3, KNOWN)
        print(f"{axis} at {1e3 * gap:g} mm: |1 − g T/T̂| at most {np.abs(1.0 - 0.7 * ratio).max():.3f}")
    figure, drawn = plt.subplots(figsize=(7, 3.5), layout="constrained")
    for name, (layers, settings) in CASES.items():
        errors = 1e6 * mean_errors(layers, settings)
        print(f"{name}: y, x, z in µm by period")
        print("\n".join(" ".join(f"{error:6.1f}" for error in row) for row in errors))
        drawn.semilogy(errors.mean(axis=0), ".-", label=name)
    drawn.axhline(120.0, color="#888", lw=0.8, ls="--")
    drawn.set(xlabel="period after the start", ylabel="mean error of the three axes, µm")
    drawn.legend()
    figure.savefig("docs/repetitive.png", dpi=110)
