"""Print how many samples of delay each loop survives (docs/accuracy.md#the-order-of-a-co-simulation-step).

`PYTHONPATH=tests/support python benchmarks/delay_margin.py`
"""

from collections import deque

from sampled_loop import PHASES, set_path

from maglev.own_fmus import definition
from maglev.schema.loading import load_plan
from maglev.schema.run_plan import RunPlan
from pmlsm.rigs import RIGS

RUNS = ("2dof-setpoints", "2dof-tracking-pid", "3dof-setpoints", "3dof-setpoints-improved", "3dof-tracking-pid")
STEP, STEP_TIME, STOP_TIME = 1e-3, 1.0, 6.0   # m, s, s: every axis steps from where it starts
SETTLED = 1e-4                                # m, over the last second


def settles(plan: RunPlan, delay: int) -> bool:
    """Whether the loop holds its set-point after a step, with commands that are late by a number of samples."""
    rig = RIGS[plan.name.partition("-")[0]]
    controller, plant = (definition(str(plan.fmus[name].model)).new_block() for name in ("controller", "plant"))
    for name, block in (("controller", controller), ("plant", plant)):
        for variable, start in plan.fmus[name].start.items():
            set_path(block, variable, start.value)
        assert block.start() == 0
    start_positions = {axis: getattr(plant, axis).position for axis in rig.axis_names}
    h = plan.step
    commands: deque[list[float]] = deque()
    for k in range(round(STOP_TIME / h)):
        for axis, position in start_positions.items():
            port = getattr(controller, axis)
            port.reference = position + (STEP if k * h >= STEP_TIME else 0.0)
            port.measured = getattr(plant, axis).encoder
        controller.step(k * h, h)
        commands.append([getattr(getattr(controller, motor), phase) for motor in rig.motor_names for phase in PHASES])
        values = iter(commands[0])
        if len(commands) > delay:
            commands.popleft()
        for motor in rig.motor_names:
            for phase in PHASES:
                setattr(getattr(plant, motor), phase, next(values))
        plant.step(k * h, h)
        late = k * h >= STOP_TIME - 1.0
        if plant.at_stop or (late and any(abs(getattr(plant, axis).position - getattr(controller, axis).reference)
                                          > SETTLED for axis in rig.axis_names)):
            return False
    return True


def margin(plan: RunPlan) -> int:
    """Samples of delay up to which the loop settles, by bisection."""
    good, bad = 0, 1
    while settles(plan, bad):
        good, bad = bad, 2 * bad
    while bad - good > 1:
        middle = (good + bad) // 2
        good, bad = (middle, bad) if settles(plan, middle) else (good, middle)
    return good


if __name__ == "__main__":
    for name in RUNS:
        plan = load_plan(name)
        samples = margin(plan)
        print(f"| `{name}` | {samples} | {samples * plan.step * 1e3:.3g} ms |", flush=True)
