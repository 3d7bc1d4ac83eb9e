"""Record the input files of the command lines beside this one: what plant and controller gave each other.

    python scenarios/scripts/record_inputs.py

Needs the built FMUs in the folder fmus. The start of the set-point experiments is recorded, with the first step moved
to 0.05 s, so that the files stay small and the plants, unstable without feedback, do not run away from the recording.
"""

from pathlib import Path

from scenarios.experiment import prepare
from scenarios.loading import load_scenario
from scenarios.master import Recording
from scenarios.results import write_csv
from scenarios.signals import Steps

HERE = Path(__file__).parent
STOP_TIME = 0.3    # s
STEP_TIME = 0.05   # s

PAIRS = {"2dof": "2dof-setpoints", "3dof": "3dof-setpoints-improved"}


def inputs(recording: Recording, sources: dict[str, str]) -> Recording:
    """What an FMU was given at each communication point, under its own names.

    The plant is given what the controller, stepped before it, has computed in the same step: the row after.
    """
    return Recording(recording.time[:-1], {
        target: recording.columns[source][1:] if target.endswith("_cmd") else recording.columns[source][:-1]
        for target, source in sources.items()})


def main() -> None:
    """Write an input file for each plant and each controller."""
    for rig, name in PAIRS.items():
        scenario = load_scenario(name)
        signals = [signal.model_copy(update={"times": [0.0, STEP_TIME, *signal.times[2:]]})
                   if isinstance(signal, Steps) else signal for signal in scenario.signals]
        experiment = prepare(scenario.model_copy(update={"signals": signals, "stop_time": STOP_TIME}),
                             Path("fmus"), {}, [])
        recording = experiment.run()
        for fmu in ("plant", "controller"):
            sources = {target: source for source, target in scenario.wires.values()}
            sources |= {signal.to: signal.to for signal in signals}
            of_fmu = {target.partition(".")[2]: source for target, source in sources.items()
                      if target.startswith(f"{fmu}.")}
            write_csv(HERE / f"{fmu}_{rig}_inputs.csv", inputs(recording, of_fmu))


if __name__ == "__main__":
    main()
