"""Fly the studies of the operating range with every law; their maps are for docs/operating_range.md and the report.

    python -m studies.operating_range [--rig 3dof] [--out results] [--docs docs] [--data FILE] [--jobs 2]

It draws the pictures of that page, prints its tables of shares, and writes the maps as the data that come with the
package, which the report draws; with --rig those of one rig, and the others stay. It needs native FMUs
(`maglev build --native --target host`) and takes some twenty minutes on two processors. A study that is done is not
flown again.
"""

import argparse
from pathlib import Path

import maglev
from maglev.operating_range import FILE, RigMaps, read_maps
from maglev.studies.schema import StudyFile, load_study
from pmlsm.rigs import RIGS
from studies.operating_range.maps import origin_of, read_map, shares_text, write_maps, write_pictures

LAWS = {"2dof": ("nonlinear", "linear", "pid"), "3dof": ("nonlinear", "linear", "scheduled", "pid"),
        "5dof": ("nonlinear", "linear", "pid")}
NAMES = {"pid": "PID"}


def study_of(rig: str, law: str) -> StudyFile:
    """The study of a rig, flown with one of its laws; the linear regulator is linearised about each target."""
    study, path = load_study(f"range-{rig}")
    scenario = (path.parent / study.scenario).with_name(f"{rig}-{law}.toml").resolve()
    vary = [varied.model_copy(update={"set": [*varied.set, "controller.setpoint"]})
            if law == "linear" and varied.column == "target gap" else varied for varied in study.vary]
    return study.model_copy(update={"name": f"{study.name}-{law}", "scenario": str(scenario), "vary": vary})


def main() -> None:
    """Fly, draw, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rig", choices=LAWS)
    parser.add_argument("--out", type=Path, default=Path("results"))
    parser.add_argument("--docs", type=Path, default=Path("docs"))
    parser.add_argument("--data", type=Path, default=FILE)
    parser.add_argument("--jobs", type=int)
    options = parser.parse_args()
    rigs = read_maps(options.data) if options.rig else {}
    for rig, laws in LAWS.items() if options.rig is None else [(options.rig, LAWS[options.rig])]:
        flown = {law: maglev.study(study_of(rig, law), native=True, out=options.out, jobs=options.jobs, resume=True)
                 for law in laws}
        maps = {NAMES.get(law, law): read_map(found.path) for law, found in flown.items()}
        rigs[rig] = RigMaps(maps, origin_of(found.path for found in flown.values()))
        write_pictures(options.docs / f"range-{rig}.png", f"{RIGS[rig].title}: from one air gap to another", maps)
        print(f"\n{rig}\n\n{shares_text(maps)}", flush=True)
    write_maps(options.data, rigs)


if __name__ == "__main__":
    main()
