"""A controller for a microcontroller: its C in a folder, and its costs on a Cortex-M7 that an emulator runs."""

from dataclasses import dataclass
from functools import partial
from math import inf
from pathlib import Path

from maglev.analysis.target import EmulatorError, Measured, generated, on_target, require_emulator
from maglev.api.comparing import put_in
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.errors import BuildError, ScenarioError, option
from maglev.files.scratch import scratch
from maglev.files.side_by_side import Watch, unwatched
from maglev.files.units import parse_quantity, refused_as
from maglev.files.whole_file import write_whole
from maglev.fmi.definition import FmuDefinition
from maglev.language.errors import ExportError
from maglev.runs.execution import json_text
from maglev.scenario.layers import Scenario
from maglev.scenario.loading import load_plan
from maglev.user.adoption import know_stage
from maglev.user.source import Given, carried

CLOCK = 216e6    # Hz, of a usual Cortex-M7
CYCLES = 1.5     # of an instruction, assumed: two can begin at a time, a division of doubles takes many
TIMEOUT = 60.0   # s, for an answer of the emulator


@dataclass(frozen=True)
class Target:
    """A controller as freestanding C.

    Attributes
    ----------
    folder : Path
        With the files.
    files : list of Path
        The written files: `NAME.h`, `NAME.c`, an example `main.c` over `board.h`, `CMakeLists.txt`, the board of the
        emulator, `report.txt` and `report.json`.
    report : Measured or None
        Its costs; None if it was not run.
    left_out : str
        The reason if it was not run, else empty.
    """

    folder: Path
    files: list[Path]
    report: Measured | None
    left_out: str = ""


def target(controller: Given, run: Scenario | None = None, *, stage: str | Path | None = None,
           out: str | Path = "target", fmus: str | Path | None = None, clock: float | str = CLOCK,
           cycles: float = CYCLES, watch: Watch = unwatched) -> Target:
    """Write a controller as C for a microcontroller, and measure it on an emulated Cortex-M7.

    The C is freestanding C99: no library, no memory that is allocated. A whole run is made twice, with the controller
    on this machine and in QEMU, sample by sample against the same plant. All signals must have the same bits.

    Parameters
    ----------
    controller : str, path or type
        Name of a controller of `fmus()`, or a Python file, "lqi.py" or "lqi.py:LQI", or a class that a module defines.
    run : str or path, optional
        A run of `scenarios()` or a TOML file; the setpoints of the controller's stage if not given, of your own
        NAME.toml those in NAME-setpoints.toml.
    stage : path, optional
        Description of your own stage that the controller is of.
    out : path
        Folder, in which a folder NAME is written.
    fmus : path, optional
        Folder with the FMUs, see `run`; native ones are run.
    clock : float or str
        Of the processor, Hz or with a unit, for the estimate.
    cycles : float
        Of an instruction in the mean, for the estimate.
    watch : callable, optional
        See `run`.

    Raises
    ------
    MaglevError
        If an argument cannot be used, or a signal has other bits.

    Examples
    --------
    >>> import maglev
    >>> made = maglev.target("PID2DOF", "2dof-smooth-pid")  # doctest: +SKIP
    >>> made.files[0].name  # doctest: +SKIP
    'PID2DOF.h'
    """
    with refused_as(ScenarioError, option("clock", clock)):
        frequency = parse_quantity(clock, "Hz")
    for name, value in (("clock", frequency), ("cycles", cycles)):
        if not 0.0 < value < inf:
            raise ScenarioError(f"{name} = {value:g}: expected a finite number above 0")
    if stage is not None:
        know_stage(stage)
    controller = carried(controller)
    described, files = generated(controller)
    folder = Path(out) / described.name
    report, left_out = None, ""
    try:
        require_emulator()
        plan = load_plan(run if run is not None else usual_run(described, stage))
        if "controller" not in plan.fmus:
            raise ScenarioError(f"{plan.name}: has no controller, expected a run with plant and controller")
        experiment = put_in(plan, described.name, controller, {"kind": "native", "fmus": fmus}, watch=watch)
        with watch([plan.name]) as watcher, scratch() as place:
            report = on_target(described, files, experiment, "controller", place, frequency, cycles, TIMEOUT,
                               partial(watcher, plan.name))
        files |= {"report.txt": str(report), "report.json": json_text(report.as_data())}
    except (EmulatorError, ExportError, BuildError) as error:   # no emulator, or no compiler
        left_out = f"it is not run: {error}"
    for file, text in files.items():
        write_whole(folder / file, text)
    return Target(folder, [folder / file for file in files], report, left_out)


def usual_run(definition: FmuDefinition, stage: str | Path | None) -> str | Path:
    """The setpoints next to the description of a user's stage, or those of the stage whose ports it has."""
    if stage is not None:
        return Path(stage).with_name(f"{Path(stage).stem}-setpoints.toml")
    names = {v.name for v in definition.variables}
    for description in PACKAGED_STAGES.values():
        ports = {f"{current}_cmd"
                 for current in description.phase_names} | {f"{axis}.reference" for axis in description.axis_names} | {
            encoder.replace("encoder", "measured") for encoder in description.encoders}
        if ports <= names:
            return f"{description.name}-setpoints"
    raise ScenarioError(f"{definition.name}: belongs to no stage of this project, needs {option('run')}: a run of its "
                        "own")
