"""Measure how much noise, delay, loss and lack of voltage each law tolerates: the tables of docs/results_faults.md.

    python -m studies.tolerances [--stage 3dof] [--out results] [--jobs 2]

One of them gets worse at a time, all else being ideal. A study that is done is not run again.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import maglev
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.fmi_units import typeset_unit
from maglev.files.marked import markdown_table, write_part
from maglev.many.study_file import StudyFile, read_study
from maglev.scenario.layers import PACKAGED
from pmlsm.stage_description import StageDescription

DOCS = Path(__file__).parents[1] / "docs" / "results_faults.md"
LAWS = {"2dof": ("nonlinear", "linear", "pid"), "3dof": ("nonlinear", "linear", "scheduled", "pid"),
        "5dof": ("nonlinear", "linear", "pid")}
NAMES = {"pid": "PID"}

SIZES = (1.0, 3.0)    # mm, by which the gap is asked to become smaller, from where the loops of the steps begin
BESIDE = {False: "5 mm", True: "2 mrad"}   # steps of horizontal axes with it, or of the tilts of a platform that tilts
FAR = {False: "1 mm", True: "5 mrad"}      # of an axis or of a tilt from its reference: as `fail_error` and `fail_tilt`

SCENARIO = """\
extends = ["{steps}", "{measurement}"]
name = "tolerance-{stage}-{law}"
title = "{title}: a step with measurements and a supply that are not ideal"
stop_time = "5 s"
"""


@dataclass(frozen=True)
class Disturbance:
    """A condition that gets worse, from its harmless value."""

    name: str
    unit: str
    values: tuple[float, ...]   # in the unit, the harmless one, 0, first
    sets: str                   # its parameter; {} means each encoder

    def text(self, value: float) -> str:
        return f"{value:g} {typeset_unit(self.unit)}"


DISTURBANCES = (
    Disturbance("noise", "um", (0, 2, 5, 10, 20, 50, 100, 200), "measurement.{}.noise"),
    Disturbance("delay", "ms", (0, 1, 2, 4, 6, 8, 10, 12, 15), "measurement.delay"),
    Disturbance("bus voltage", "V", (0, 48, 24, 18, 12, 9, 6, 4), "plant.bus_voltage"),   # 0: without a limit
    Disturbance("lost samples", "%", (0, 20, 40, 60, 80, 90, 95, 98, 99), "measurement.{}.lost"))
HEADS = ("controller", "step of the gap", *(each.name for each in DISTURBANCES))


def study_of(stage: StageDescription, law: str, folder: Path) -> StudyFile:
    """Return the study of a law: for each step all values of the first disturbance, then of the second, and so on.

    Its scenario is written into a folder.
    """
    scenario = folder / f"tolerance-{stage.name}-{law}.toml"
    folder.mkdir(parents=True, exist_ok=True)
    scenario.write_text(SCENARIO.format(
        steps=(PACKAGED / "steps" / f"{stage.name}-{law}.toml").as_posix(), title=stage.title, stage=stage.name,
        law=law, measurement=(PACKAGED / "loops" / f"{stage.name}-measurement.toml").as_posix()), encoding="utf-8")
    gap, start = stage.vertical.name, 1e3 * stage.vertical.start
    measured = [encoder.rpartition(".")[0] for encoder in stage.encoders]
    rows = [(size, disturbed, value) for size in SIZES for disturbed in DISTURBANCES for value in disturbed.values]
    vary = [{"name": each.name, "kind": "list",
             "values": [f"{value if each is disturbed else 0:g} {each.unit}" for _, disturbed, value in rows],
             "set": [each.sets.format(name) for name in measured] if "{}" in each.sets else [each.sets]}
            for each in DISTURBANCES]
    steps = {"name": "target gap", "kind": "list", "values": [f"{start - size:g} mm" for size, _, _ in rows],
             "set": [f"reference.{gap}.end", *(["controller.setpoint"] if law == "linear" else [])]}
    beside = {f"reference.{axis.name}.end": BESIDE[bool(stage.rotations)]
              for axis in stage.rotations or stage.horizontal}
    limits = {f"end error of {axis.name}": {"max": FAR[axis.rotation]} for axis in stage.axes}
    return read_study({
        "name": f"tolerance-{stage.name}-{law}",
        "scenario": str(scenario.resolve()),
        "design": {"kind": "rows"},
        "vary": [*vary, steps],
        "set": beside,
        "metrics": ["end error"],
        "limits": {"failed": {"max": 0}, **limits}}, scenario)


def worst_value(held: Sequence[bool], disturbance: Disturbance) -> str:
    """Return the worst value up to which every run held; `held` has one for each value."""
    count = [*held, False].index(False)
    return "—" if not count else disturbance.text(disturbance.values[count - 1]) + (
        " and worse" if count == len(held) else "")


def rows_of(law: str, held: Sequence[bool]) -> list[tuple[str, ...]]:
    """Return the rows of a law, one for each step; `held` has the order of the study's samples."""
    runs = iter(held)
    return [(NAMES.get(law, law), f"{size:g} mm",
             *(worst_value([next(runs) for _ in each.values], each) for each in DISTURBANCES)) for size in SIZES]


def main() -> None:
    """Run all studies, and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stage", choices=LAWS)
    parser.add_argument("--out", type=Path, default=Path("results"))
    parser.add_argument("--jobs", type=int)
    options = parser.parse_args()
    for stage in [options.stage] if options.stage else LAWS:
        rows = []
        for law in LAWS[stage]:
            study = study_of(PACKAGED_STAGES[stage], law, options.out / "tolerances")
            done = maglev.study(study, out=options.out, jobs=options.jobs, resume=True)
            rows += rows_of(law, done.to_arrow()["passed"].to_pylist())
        print(stage, *rows, sep="\n", flush=True)
        write_part(DOCS, f"tolerances-{stage}", markdown_table(HEADS, rows, len(DISTURBANCES)))


if __name__ == "__main__":
    main()
