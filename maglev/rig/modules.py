"""All that is written of a rig: its blocks, the modules that make FMUs of them, and their equations."""

from collections.abc import Callable, Mapping
from pathlib import Path

from maglev.rig.closed_loop import closed_loop
from maglev.rig.controllers import commutation, pid, regulator
from maglev.rig.definitions import closed_loops, description, laws, plant, regulators, single
from maglev.rig.estimator import estimator
from maglev.rig.pages import linearisation_page, rows_page, setpoint_page, stage_page
from maglev.rig.stage import stage
from maglev.rig.tilting import controllers as tilting
from maglev.rig.tilting.stage import tilting_stage
from pmlsm.rig import Rig

# By path, in which {} is the name of the rig.
WRITERS: Mapping[str, Callable[[Rig], str]] = {
    "pmlsm/rig_{}.py": description,
    "plant_fmu/stage_{}.py": stage,
    "plant_fmu/plant_{}.py": plant,
    "controller_fmu/regulator_{}.py": regulator,
    "controller_fmu/regulator_{}_fmu.py": regulators,
    "controller_fmu/pid_{}.py": pid,
    "controller_fmu/pid_{}_fmu.py": single("controller_fmu", "PID", "pid"),
    "controller_fmu/commutation_{}.py": commutation,
    "controller_fmu/commutation_{}_fmu.py": single("controller_fmu", "Commutation", "commutation"),
    "estimator_fmu/estimator_{}.py": estimator,
    "estimator_fmu/estimator_{}_fmu.py": single("estimator_fmu", "Estimator", "estimator"),
    "closed_loop_fmu/closed_loop_{}.py": closed_loop,
    "closed_loop_fmu/closed_loop_{}_fmu.py": closed_loops,
    "plant_fmu/documentation/stage_{}.html": stage_page,
    "controller_fmu/documentation/linearisation_{}.html": linearisation_page,
    "controller_fmu/documentation/setpoint_{}.html": setpoint_page,
    "estimator_fmu/documentation/rows_{}.html": rows_page}

# Those of a rig whose platform tilts, whose equations are the same for all such rigs.
TILTING: Mapping[str, Callable[[Rig], str]] = {
    **{path: writer for path, writer in WRITERS.items() if not path.endswith(".html")},
    "plant_fmu/stage_{}.py": tilting_stage,
    "controller_fmu/regulator_{}.py": tilting.regulator,
    "controller_fmu/pid_{}.py": tilting.pid,
    "controller_fmu/commutation_{}.py": tilting.commutation}

REGULATORS = {"NONLINEAR": "Regulator", "LINEAR": "LinearRegulator", "SCHEDULED": "ScheduledRegulator"}


def writers(rig: Rig) -> Mapping[str, Callable[[Rig], str]]:
    """Writers of the modules of a rig, by path."""
    return TILTING if rig.rotations else WRITERS


def written(rig: Rig) -> dict[str, str]:
    """Text of every module of a rig, by its path from the folder of the packages."""
    return {path.format(rig.name): writer(rig) for path, writer in writers(rig).items()}


def write(rig: Rig, root: Path) -> None:
    """Write the modules of a rig below a folder that holds the packages."""
    for path, text in written(rig).items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text, encoding="utf-8")


def definitions(rig: Rig) -> dict[str, tuple[str, str]]:
    """Module and attribute of every FMU of a rig, by its name."""
    name, suffix = rig.name, rig.suffix
    loops = {law: REGULATORS[law].removesuffix("Regulator") for law in laws(rig)}
    made = {path.format(name).removesuffix(".py").replace("/", ".") for path in writers(rig)}
    found = {
        f"Plant{suffix}": (f"plant_fmu.plant_{name}", "PLANT"),
        **{f"{REGULATORS[law]}{suffix}": (f"controller_fmu.regulator_{name}_fmu",
                                          REGULATORS[law].replace("Regulator", "_Regulator").strip("_").upper())
           for law in laws(rig)},
        f"PID{suffix}": (f"controller_fmu.pid_{name}_fmu", "PID"),
        f"Commutation{suffix}": (f"controller_fmu.commutation_{name}_fmu", "COMMUTATION"),
        f"Estimator{suffix}": (f"estimator_fmu.estimator_{name}_fmu", "ESTIMATOR"),
        **{f"ClosedLoop{kind}{suffix}": (f"closed_loop_fmu.closed_loop_{name}_fmu", f"CLOSED_LOOP_{law}")
           for law, kind in loops.items()},
        f"ClosedLoopPID{suffix}": (f"closed_loop_fmu.closed_loop_{name}_fmu", "CLOSED_LOOP_PID")}
    return {fmu: place for fmu, place in found.items() if place[0] in made}
