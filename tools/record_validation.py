"""Record the validations that the FMUs carry: what each was given and gave at the start of an experiment.

    python tools/record_validation.py

Needs the built FMUs in the folder fmus. Writes scenarios/validation, which the build puts into the FMUs. Each FMU is
run in the setpoint experiment of its rig, or in the first scenario that has it, a few hundred steps long and with
the first step of the references at a fifth of that. The closed loops get the references alone.
"""

import sys
from collections.abc import Mapping
from pathlib import Path

from fmi_export.experiments.files import VALIDATION
from maglev.experiment.preparation import prepare
from maglev.fmu_experiments.pack import recorded_experiment
from maglev.own_fmus import DEFINITIONS, definition
from maglev.rig.rigs import RIGS
from maglev.schema.layers import PACKAGED, packaged_runs
from maglev.schema.loading import load_plan
from maglev.schema.run_plan import CheckSettings, FmuTable, RunPlan
from maglev.schema.signals.kinds import Sinusoids, Steps
from maglev_files.whole_file import write_whole

FOLDER = PACKAGED / "validation"
STEPS, LOOP_STEPS = 200, 20   # communication steps; those of the closed loops are long
EVERY, LOOP_EVERY = 10, 1     # of which one is in the results
DIGITS = 9                    # of the results
FIRST = 0.2                   # of the time, at which the references step


def run_with(name: str) -> tuple[RunPlan, str] | None:
    """Run in which an FMU is run, and its name in it; None if there is none."""
    first = {rig.suffix: rig.experiment or f"{key}-setpoints" for key, rig in RIGS.items()}
    for run in [*first.values(), *packaged_runs()]:
        plan = load_plan(run)
        fmu = next((fmu for fmu, table in plan.fmus.items() if table.model == name), None)
        if fmu is not None and not plan.needs:
            return plan, fmu
    plan = load_plan(next(run for suffix, run in first.items() if name.endswith(suffix)))
    places = {f"{v.place.partition('.')[0]}.{v.name}": f"loop.{v.name}" for v in definition(name).variables
              if v.causality == "input"}
    return (loop_plan(plan, name, places), "loop") if {signal.to for signal in plan.signals} <= places.keys() else None


def loop_plan(plan: RunPlan, name: str, inputs: Mapping[str, str]) -> RunPlan:
    """The references of a run, given to a closed loop, whose inputs are by their names in the run."""
    signals = [signal.model_copy(update={"to": inputs[signal.to], "rate_to": inputs.get(signal.rate_to or "")})
               for signal in plan.signals]
    step = definition(name).experiment.step
    return plan.model_copy(update={"fmus": {"loop": FmuTable(model=name)}, "connections": [], "signals": signals,
                                   "step": step, "output_interval": step, "axes": {}, "motors": {}, "stop_flag": None,
                                   "trip_flag": None, "check": CheckSettings(), "claims": [], "events": []})


def early(plan: RunPlan, stop_time: float) -> RunPlan:
    """The start of an experiment, to a stop time (s), in which something happens soon."""
    def soon(signal: object) -> object:
        if isinstance(signal, Steps):
            return signal.model_copy(update={"times": [0.0, FIRST * stop_time, *signal.times[2:]]})
        return signal.model_copy(update={"ramp": FIRST * stop_time}) if isinstance(signal, Sinusoids) else signal

    return plan.model_copy(update={"signals": [soon(signal) for signal in plan.signals], "stop_time": stop_time})


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    for name in sys.argv[1:] or DEFINITIONS:
        found_run = run_with(name)
        if found_run is None:
            print(f"{name}: no scenario has it, expected one")
            continue
        plan, fmu = found_run
        steps, every = (LOOP_STEPS, LOOP_EVERY) if fmu == "loop" else (STEPS, EVERY)
        experiment = prepare(early(plan, steps * plan.step), Path("fmus"), {}, {})
        files = recorded_experiment(experiment, experiment.run(), fmu, f"{name}_validation", VALIDATION,
                                    f"{name} as in the start of the scenario {plan.name}", every, DIGITS)
        made = files.files()
        for file, data in made.items():
            write_whole(FOLDER / file, data)
        for old in FOLDER.glob(f"{files.name}*"):
            if old.name not in made:
                old.unlink()


if __name__ == "__main__":
    main()
