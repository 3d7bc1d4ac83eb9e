"""Accuracy and cost of the plants by their longest integration step, as the table of docs/accuracy.md.

    PYTHONPATH=tests/support python benchmarks/accuracy_study.py
"""

from time import perf_counter
from typing import Any

from stage_cases import IMPACTS, SMOOTH, Case, differences

import plant_fmu.stage_2dof
import plant_fmu.stage_3dof
from pmlsm.rigs import RIGS

MODULES: dict[int, Any] = {2: plant_fmu.stage_2dof, 3: plant_fmu.stage_3dof}
STAGES: dict[int, type[Any]] = {2: plant_fmu.stage_2dof.Stage2DOF, 3: plant_fmu.stage_3dof.Stage3DOF}
STEP = {2: RIGS["2dof"].sample_time, 3: RIGS["3dof"].sample_time}   # s, communication steps
LONGEST_STEPS = (0.5e-3, 0.25e-3, 0.2e-3, 0.125e-3, 0.1e-3, 0.05e-3)   # s
ROUNDS = 5


def worst(cases: list[Case]) -> tuple[float, float]:
    """Largest differences of position (m) and velocity (m/s) over cases."""
    found = [differences(case) for case in cases]
    return max(position for position, _ in found), max(velocity for _, velocity in found)


def cost(rig: int) -> float:
    """Time of one communication step, s."""
    times = []
    for _ in range(ROUNDS):
        stage = STAGES[rig]()
        stage.start()
        begin = perf_counter()
        for k in range(300):
            stage.step(k * STEP[rig], STEP[rig])
        times.append((perf_counter() - begin) / 300)
    return min(times)


def main() -> None:
    """Print the table."""
    print("| stage | longest step | position, smooth (m) | velocity, smooth (m/s) | position, after a stop (m) "
          "| cost |")
    print("|---|---|---|---|---|---|")
    for rig, module in MODULES.items():
        chosen = module.LONGEST_STEP
        unit = cost(rig)
        smooth = [case for case in SMOOTH if case.rig == rig]
        impacts = [case for case in IMPACTS if case.rig == rig]
        for longest in LONGEST_STEPS:
            if longest > STEP[rig]:
                continue
            module.LONGEST_STEP = longest
            (position, velocity), (after, _) = worst(smooth), worst(impacts)
            mark = "**" if longest == chosen else ""
            print(f"| {rig}-DOF | {mark}{1e3 * longest:g} ms{mark} | {position:.1e} | {velocity:.1e} | {after:.1e} "
                  f"| {cost(rig) / unit:.1f} |", flush=True)
        module.LONGEST_STEP = chosen


if __name__ == "__main__":
    main()
