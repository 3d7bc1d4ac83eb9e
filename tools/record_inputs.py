"""Record the input files of the command lines in scenarios/scripts: what plant, controller and estimator got in a run.

    python tools/record_inputs.py

Needs the built FMUs in the folder fmus. For plants and controllers the start of the set-point experiments is recorded,
with the first step moved to 0.05 s, so that the files stay small and the plants, unstable without feedback, do not run
away from the recording. For the estimators it is the start of Procedure 4, with an excitation that is there sooner.
"""

from pathlib import Path

from maglev.cosim.master import Recording
from maglev.experiment.preparation import prepare
from maglev.experiment.results import write_csv
from maglev.schema.loading import load_scenario
from maglev.schema.scenario import Scenario
from maglev.schema.signals import Sinusoids, Steps
from maglev.schema.toml_table import PACKAGED

SCRIPTS = PACKAGED / "scripts"
STOP_TIME = 0.3    # s
STEP_TIME = 0.05   # s
RAMP = 0.2         # s

PAIRS = {"2dof": "2dof-setpoints", "3dof": "3dof-setpoints-improved"}
ESTIMATED = {"2dof": ("2dof-identification-rig", 1.0), "3dof": ("3dof-identification-rig", 0.5)}   # and stop time, s


def early(scenario: Scenario) -> Scenario:
    """The start of a set-point experiment, with an early first step."""
    signals = [signal.model_copy(update={"times": [0.0, STEP_TIME, *signal.times[2:]]})
               if isinstance(signal, Steps) else signal for signal in scenario.signals]
    return scenario.model_copy(update={"signals": signals, "stop_time": STOP_TIME})


def excited(scenario: Scenario, stop_time: float) -> Scenario:
    """The start of Procedure 4, to a stop time (s), with the excitation ramped in at once."""
    signals = [signal.model_copy(update={"ramp": RAMP}) if isinstance(signal, Sinusoids) else signal
               for signal in scenario.signals]
    return scenario.model_copy(update={"signals": signals, "stop_time": stop_time})


def inputs(scenario: Scenario, recording: Recording, fmu: str) -> Recording:
    """What an FMU was given at each communication point, under its own names.

    What an FMU that is stepped before it computes in the same step is the row after.
    """
    order = list(scenario.fmus)
    sources = {target: source for source, target in scenario.wires.values()}
    sources |= {signal.to: signal.to for signal in scenario.signals}
    columns = {}
    for target, source in sources.items():
        owner, _, name = target.partition(".")
        if owner == fmu:
            before = order.index(source.partition(".")[0]) < order.index(fmu)
            columns[name] = recording.columns[source][1:] if before else recording.columns[source][:-1]
    return Recording(recording.time[:-1], columns)


def record(scenario: Scenario, files: dict[str, Path]) -> None:
    """Run a scenario and write an input file for each FMU that is named."""
    recording = prepare(scenario, Path("fmus"), {}, []).run()
    for fmu, path in files.items():
        write_csv(path, inputs(scenario, recording, fmu))


def main() -> None:
    """Write an input file for each plant, each controller and each estimator."""
    for rig, name in PAIRS.items():
        files = {fmu: SCRIPTS / f"{fmu}_{rig}_inputs.csv" for fmu in ("plant", "controller")}
        record(early(load_scenario(name)), files)
    for rig, (name, stop_time) in ESTIMATED.items():
        record(excited(load_scenario(name), stop_time), {"estimator_10ms": SCRIPTS / f"estimator_{rig}_inputs.csv"})


if __name__ == "__main__":
    main()
