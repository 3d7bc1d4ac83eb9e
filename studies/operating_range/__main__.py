"""Fly the studies of the operating range with every law; their maps are for docs/operating_range.md and the report.

    python -m studies.operating_range [--rig 3dof] [--out results] [--docs docs] [--data FILE] [--jobs 2]

It draws the pictures of that page, prints its tables of shares, and writes the maps as the data that come with the
package, which the report draws; with --rig those of one rig, and the others stay. It needs native FMUs
(`maglev build --native --target host`) and takes some twenty minutes on two processors. A study that is done is not
flown again.
"""

import argparse

from maglev.maps.operating_range import FILE, OUTCOMES, SETTLED_NOMINAL, RigMaps, read_maps
from maglev.studies.schema import StudyFile, load_study
from pmlsm.rigs import RIGS
from studies.laws import NAMES, Fly, map_laws, markdown_table, origin_of
from studies.operating_range.maps import read_map, write_maps
from studies.pictures import write_picture

COLOURS = ("#2a9d5c", "#a8d5a2", "#f4c152", "#8fa7c4", "#8e6bb0", "#c8503c")   # of the outcomes


def study_of(rig: str, law: str) -> StudyFile:
    """The study of a rig, flown with one of its laws; the linear regulator is linearised about each target."""
    study, path = load_study(f"range-{rig}")
    scenario = (path.parent / study.scenario).with_name(f"{rig}-{law}.toml").resolve()
    vary = [varied.model_copy(update={"set": [*varied.set, "controller.setpoint"]})
            if law == "linear" and varied.column == "target gap" else varied for varied in study.vary]
    return study.model_copy(update={"name": f"{study.name}-{law}", "scenario": str(scenario), "vary": vary})


def fly_rig(rig: str, laws: tuple[str, ...], fly: Fly, options: argparse.Namespace) -> RigMaps:
    flown = {law: fly(study_of(rig, law)) for law in laws}
    maps = RigMaps({NAMES.get(law, law): read_map(path) for law, path in flown.items()}, origin_of(flown.values()))
    write_picture(options.docs / f"range-{rig}.png", f"{RIGS[rig].title}: from one air gap to another", maps.rows(),
                  OUTCOMES, COLOURS, SETTLED_NOMINAL)
    print(f"\n{rig}\n\n{markdown_table(maps.table())}", flush=True)
    return maps


if __name__ == "__main__":
    map_laws(__doc__, FILE, read_maps, write_maps, fly_rig)
