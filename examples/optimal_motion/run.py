"""Run the planned motions and a step of the same distance with the thesis's regulator, for a table and a picture.

    python examples/optimal_motion/run.py
"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image  # matplotlib brings it

import maglev

HERE = Path(__file__).parent
COLOURS = {"step": "tab:gray", "fastest": "tab:red", "thrifty": "tab:blue"}
GOALS = {"y": (25e-3, 27e-3), "x": (0.0, 10e-3), "z": (0.0, -15e-3)}   # m, from and to
BEGIN = 0.2         # s
RESISTANCE = 3.5    # ohm, of a phase
PHASES = [f"plant.{motor}.i_{phase}" for motor in ("alpha", "beta") for phase in "abc"]


def settling(run: maglev.Run, axis: str, band: float) -> float:
    """Time (s) from the beginning to the last sample that is further than a band (m) from the goal."""
    outside = np.abs(run[f"plant.{axis}.position"] - GOALS[axis][1]) > band
    return float(run.time[outside][-1]) - BEGIN


def overshoot(run: maglev.Run, axis: str) -> float:
    """Largest way beyond the goal, of the distance."""
    start, goal = GOALS[axis]
    return float(((run[f"plant.{axis}.position"] - goal) / (goal - start)).max())


def energy(run: maglev.Run, end: float) -> float:
    """Return the loss in the windings (J) from the beginning to a time (s)."""
    during = (run.time >= BEGIN) & (run.time <= end + 1e-9)
    return float(np.trapezoid(RESISTANCE * sum(run[name][during]**2 for name in PHASES), run.time[during]))


def lag(run: maglev.Run, axis: str) -> float:
    """Largest distance (m) from the reference after the beginning."""
    after = run.time > BEGIN
    return float(np.abs(run[f"plant.{axis}.position"] - run[f"controller.{axis}.reference"])[after].max())


def motion_table(runs: dict[str, maglev.Run]) -> str:
    """Return the measured values, a column for each run."""
    def row(name: str, form: str, of: object) -> str:
        return f"{name:34}" + "".join(f"{', '.join(format(v, form) for v in of(run)):>26}" for run in runs.values())

    return "\n".join((
        f"{'y, x, z':34}" + "".join(f"{name:>26}" for name in runs),
        row("settling time to 0.1 mm (s)", ".2f", lambda run: [settling(run, a, 1e-4) for a in GOALS]),
        row("settling time to 10 µm (s)", ".2f", lambda run: [settling(run, a, 1e-5) for a in GOALS]),
        row("overshoot (%)", ".1f", lambda run: [100.0 * overshoot(run, a) for a in GOALS]),
        row("largest error (mm)", ".2f", lambda run: [1e3 * lag(run, a) for a in GOALS]),
        row("energy of the first second (J)", ".1f", lambda run: [energy(run, BEGIN + 1.0)]),
        row("peak of a phase current (A)", ".2f", lambda run: [max(np.abs(run[name]).max() for name in PHASES)])))


def draw_motions(runs: dict[str, maglev.Run], path: Path) -> None:
    """Draw the planned motions and the motions of the runs."""
    figure, axes = plt.subplots(3, 2, figsize=(11, 7), layout="constrained")
    for k, axis in enumerate(GOALS):
        for name, run in runs.items():
            axes[k, 0].plot(run.time - BEGIN, 1e3 * run[f"plant.{axis}.position"], color=COLOURS[name], label=name)
            if name != "step":
                axes[k, 0].plot(run.time - BEGIN, 1e3 * run[f"controller.{axis}.reference"], "--", lw=0.9,
                                color=COLOURS[name])
        axes[k, 0].set(xlim=(-0.05, 1.5), ylabel=f"{axis} (mm)")
        axes[k, 0].grid(alpha=0.3)
    axes[0, 0].set_title("run (solid) and planned (dashed)")
    axes[0, 0].invert_yaxis()   # a larger gap is lower
    axes[0, 0].legend()
    axes[2, 0].set_xlabel("time from the beginning (s)")
    for name in ("fastest", "thrifty"):
        rows = np.genfromtxt(HERE / f"{name}.csv", delimiter=",", names=True, deletechars="")
        share = (rows["time"][1:] - BEGIN) / (rows["time"][-1] - BEGIN)
        for panel, current in zip(axes[:, 1], ("alpha.i_d", "alpha.i_q", "beta.i_q"), strict=True):
            panel.step(share, rows[current][1:], where="post", color=COLOURS[name])
            panel.set(ylabel=f"{current} (A)", xlim=(0, 1), ylim=(-5, 5))
            panel.grid(alpha=0.3)
    axes[0, 1].set_title("planned currents")
    axes[2, 1].set_xlabel("share of the duration (0.158 s and 0.6 s)")
    figure.savefig(path, dpi=80)
    plt.close(figure)
    with Image.open(path) as drawn:   # lines need few colours
        drawn.convert("RGB").quantize(64, dither=Image.Dither.NONE).save(path, optimize=True)


def main() -> None:
    """Run, print, draw."""
    parser = argparse.ArgumentParser(description="run the planned motions next to a step")
    parser.add_argument("--fmus", help="folder with FMUs, instead of those that are built for the run")
    parser.add_argument("--out", type=Path, default=Path("results"), help="folder for the picture")
    asked = parser.parse_args()
    runs = {name: maglev.run(HERE / f"{name}.toml", fmus=asked.fmus) for name in COLOURS}
    print(motion_table(runs))
    asked.out.mkdir(parents=True, exist_ok=True)
    draw_motions(runs, asked.out / "optimal_motion.png")
    print(asked.out / "optimal_motion.png")


if __name__ == "__main__":
    main()
