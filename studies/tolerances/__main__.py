"""Fly every law with noise and delay of its measurements, with lost samples and with a low bus voltage.

    python -m studies.tolerances [--rig 3dof] [--out results] [--docs docs] [--data FILE] [--jobs 2]

It draws the pictures of docs/tolerances.md, prints its tables, and writes what was found as data that come with the
package, which the report draws; with --rig that of one rig, and the others stay. It needs native FMUs
(`maglev build --native --target host`) and takes some ten minutes on two processors. A study that is done is not flown
again.
"""

import argparse
from pathlib import Path

from maglev.maps.rows import Outcomes
from maglev.maps.tolerances import FILE, OUTCOMES, QUESTIONS, Question, RigMaps, read_tolerances
from maglev.schema.layers import PACKAGED
from maglev.studies.schema import StudyFile, read_study
from pmlsm.rig import Rig
from pmlsm.rigs import RIGS
from studies.laws import NAMES, Fly, map_laws, markdown_table, origin_of
from studies.pictures import write_picture
from studies.tolerances.maps import read_outcomes, write_found

SIZES = (1.0, 3.0)    # mm, by which the gap is asked to become smaller, from where the loops of the steps begin
BESIDE = {False: "5 mm", True: "2 mrad"}   # steps of horizontal axes with it, or of the tilts of a platform that tilts

COLOURS = ("#2a9d5c", "#f4c152", "#c8503c", "#8e6bb0")   # of the outcomes

SCENARIO = """\
extends = ["{steps}", "{measurement}"]
name = "tolerance-{rig}-{law}"
title = "{title}: a step with measurements and a supply that are not ideal"
stop_time = "5 s"
"""


def encoders(rig: Rig) -> list[str]:
    """Names of what is measured."""
    return [axis.name for axis in rig.measured] + [motor for motor in rig.motor_names if rig.rotations]


def study_of(rig: Rig, law: str, question: Question, folder: Path) -> StudyFile:
    """Study of a question with a law; its scenario is written into a folder."""
    scenario = folder / f"tolerance-{rig.name}-{law}.toml"
    folder.mkdir(parents=True, exist_ok=True)
    scenario.write_text(SCENARIO.format(
        steps=(PACKAGED / "steps" / f"{rig.name}-{law}.toml").as_posix(), title=rig.title, rig=rig.name, law=law,
        measurement=(PACKAGED / "loops" / f"{rig.name}-measurement.toml").as_posix()), encoding="utf-8")
    gap, start = rig.vertical.name, 1e3 * rig.vertical.start
    vary = [{"name": each.name, "kind": "list", "values": [f"{value:g} {each.unit}" for value in each.values],
             "set": [each.sets.format(encoder) for encoder in encoders(rig)] if "{}" in each.sets else [each.sets]}
            for each in (question.down, question.along)]
    steps = {"name": "target gap", "kind": "list", "values": [f"{start - size:g} mm" for size in SIZES],
             "set": [f"reference.{gap}.end", *(["controller.setpoint"] if law == "linear" else [])]}
    beside = {f"reference.{axis.name}.end": BESIDE[bool(rig.rotations)] for axis in rig.rotations or rig.horizontal}
    return read_study({"name": f"tolerance-{rig.name}-{law}-{question.name}", "scenario": str(scenario.resolve()),
                       "vary": [*vary, steps], "set": beside, "metrics": ["end error"]}, scenario)


def fly_rig(name: str, laws: tuple[str, ...], fly: Fly, options: argparse.Namespace) -> RigMaps:
    rig, paths = RIGS[name], list[Path]()
    maps: dict[str, dict[str, Outcomes]] = {}
    for question in QUESTIONS:
        for law in laws:
            paths.append(fly(study_of(rig, law, question, options.out / "tolerances")))
            maps.setdefault(question.name, {})[NAMES.get(law, law)] = read_outcomes(paths[-1], question)
    found = RigMaps(SIZES, maps, origin_of(paths))
    write_picture(options.docs / f"tolerances-{name}.png", f"{rig.title}: what each law tolerates", found.rows(),
                  OUTCOMES, COLOURS)
    print(f"\n{name}\n\n{markdown_table(found.table())}", flush=True)
    return found


if __name__ == "__main__":
    map_laws(__doc__, FILE, read_tolerances, write_found, fly_rig)
