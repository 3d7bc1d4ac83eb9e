"""Any plant and controller: made ready to run about a point, and run until they rest."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
from fmpy.model_description import ModelDescription, ScalarVariable

from maglev.analysis.participant import Participant, Sign, no_sign
from maglev.cosim.helper_process import called_apart
from maglev.cosim.isolated_run import TIMEOUT
from maglev.cosim.master import FmuSetup
from maglev.cosim.open import describe
from maglev.cosim.port_map import PortMap, apply, read_port_maps
from maglev.descriptions.own_fmus import current_fmu
from maglev.descriptions.registry import known_stages
from maglev.files.arrays import Array
from maglev.files.errors import ControllerError, LinearModelError, nearest, one_of, or_of_own_stage
from maglev.files.json_lines import hints
from maglev.files.units import positive_time
from maglev.files.worker_process import Send
from maglev.fmi.parameter import Parameter, require_parameter
from maglev.linear.equilibrium import read_positions
from maglev.linear.loop import opening_among, openings_of
from maglev.linear.model import Equilibrium
from maglev.linear.parameters import Quantity, block_of, controllers, plants
from maglev.linear.places import MotorPlaces
from maglev.scenario.fmus_for_runs import fmus_named
from maglev.user.adoption import know_stage
from maglev.user.scenario_loop import loop_table
from maglev.user.source import FmuFile, Given, PythonClass, Source, name_of, source_of
from pmlsm.dq_transform import clarke, park
from pmlsm.sine_cosine import sine_cosine
from pmlsm.stage_description import StageDescription

SETTLE = 10.0        # s, at most, that a loop runs before it is looked at
LOOK = 0.5           # s, interval of the tests whether the loop rests
CALM = 1e-9          # m or rad, by which it then moves no more
AT_REST = 20e-6      # m or rad, by which it may still move in the end
NOT_THERE = 1e-3     # m or rad, by which it may miss the place that was asked for

SMOOTH = (".friction.coulomb", "encoder.resolution")   # ends of the names of parameters without a derivative in a plant

Settings = Mapping[str, Quantity | bool]
Found = TypeVar("Found")


@dataclass(frozen=True)
class Pair:
    """A plant and a controller with their connections."""

    stage: StageDescription
    plant: FmuSetup
    controller: FmuSetup
    plant_name: str
    controller_name: str
    step: float                    # sample time, s
    positions: dict[str, float]    # where it is to rest, m or rad
    signals: dict[str, str]        # outputs of the plant by the inputs of the controller that they go to
    commands: tuple[str, ...]      # outputs of the controller, which the plant has as inputs
    references: dict[str, float]   # other inputs of the controller, with their values

    @property
    def name(self) -> str:
        return f"{self.plant_name} with {self.controller_name}"

    @property
    def own_plant(self) -> str | None:
        """Name of the plant if it is one of this project, or of a user's stage."""
        return self.plant_name if self.plant_name in plants() else None

    @property
    def openings(self) -> dict[str, tuple[Array, Array]]:
        """Return where the loop can be opened or injected into: the effect of each place on the signals, and of these
        on it.

        Shapes (signals,), (signals,). Where the platform tilts, a tilt lies in the gaps at all motors.
        """
        names = tuple(self.signals)
        straight = {name: (row, row) for name, row in zip(names, np.eye(len(names)), strict=True)}
        if not self.stage.rotations:
            return straight
        owners = (*self.stage.axis_names, *self.stage.motor_names)
        by_owner = np.vstack([np.eye(len(self.stage.axes)), MotorPlaces.of(self.stage).gaps])
        along = by_owner[[owners.index(name.rpartition(".")[0]) for name in names]]
        read = np.linalg.pinv(along)
        axes = {f"{axis}.measured": (read[k], along[:, k]) for k, axis in enumerate(self.stage.axis_names)}
        return {**axes, **{name: way for name, way in straight.items() if name not in axes}}

    def opening(self, at: str) -> str:
        """Full name of a signal that a user names; LinearModelError if there is none."""
        return measured_among(at, self.openings, self.name)


def measured_among(at: str, known: Collection[str], pair: str) -> str:
    """Return the full name of a measured signal that a user names; LinearModelError if it is not known."""
    for name in (at, f"{at}.measured", f"{at}.gap_measured"):
        if name in known:
            return name
    raise LinearModelError(f"{pair}: no measured signal {at!r}, expected {one_of(at, known)}")


@dataclass(frozen=True, eq=False)
class Rest:
    """A pair that has come to rest; both its parts are marked there."""

    pair: Pair
    controller: Participant    # its inputs are the signals, then the references
    plant: Participant
    measured: Array            # last values of the signals, m or rad
    commanded: Array           # and of the commands, A
    equilibrium: Equilibrium   # where it rests, with the currents that are commanded there
    moving: float              # how far what is measured still moved in the last half second, m or rad


@dataclass(frozen=True)
class AskedPair:
    """A plant and a controller by the user's arguments.

    Attributes
    ----------
    plant, controller : str, Path, type or object
        Names of FMUs of this project, see `linearise`, or paths of FMUs or Python files. A controller can also be a
        class, or an object of one.
    at : mapping of str to float or str
        Position of each axis, see `linearise`.
    fmus, ports : Path, and as of `maglev.run`
        Folder of this project's FMUs, and the map of ports of other FMUs.
    plant_parameters, controller_parameters : mapping, optional
        Parameters that differ from their start values.
    sample_time : float or str, optional
        s or with a unit; if not given, that of the controller's parameter or of its map, or the stage's.
    stage : path, optional
        Description of your own stage, see `know_stage`.
    """

    plant: str | Path
    controller: Given
    at: Mapping[str, Quantity]
    fmus: Path
    ports: str | Path | None = None
    plant_parameters: Settings | None = None
    controller_parameters: Settings | None = None
    sample_time: Quantity | None = None
    stage: str | Path | None = None

    @property
    def sources(self) -> list[Source]:
        """FMUs and classes of the user."""
        return [source_of(given) for given in (self.plant, self.controller) if given not in (*plants(), *controllers())]


class Part(NamedTuple):
    """A requested plant or controller: its role, its name, its source, its names for the ports, and its description."""

    role: str
    name: str
    source: Source
    ports: PortMap | None
    description: ModelDescription

    @property
    def variables(self) -> dict[str, ScalarVariable]:
        return {variable.name: variable for variable in self.description.modelVariables}

    def setup(self, start: Mapping[str, float | bool], settings: Settings | None) -> FmuSetup:
        """The model with start values, and the user's settings instead of some of them."""
        return FmuSetup(self.role, self.source, {**start, **read_values(self.name, settings or {}, self.description)},
                        self.ports)


def make_pair(asked: AskedPair, smooth: bool = True) -> Pair:
    """Make a plant and a controller ready; an error if one of them does not exist or lacks a port or a parameter.

    `smooth` is without Coulomb friction and rounding of the encoders, where the plant has parameters for them.
    """
    if asked.stage is not None:
        know_stage(asked.stage)
    maps = {} if asked.ports is None else read_port_maps(Path(asked.ports))
    plant = part_of("plant", asked.plant, plants(), asked.fmus, maps)
    controller = part_of("controller", asked.controller, controllers(), asked.fmus, maps)
    stage = plants().get(plant.name) or controllers().get(controller.name) or stage_with(plant.variables)
    positions = read_positions(f"Plant{stage.suffix}", asked.at)
    signals, commands = pair_wires(stage, {"plant": plant, "controller": controller})
    inputs = {name for name, variable in controller.variables.items() if variable.causality == "input"}
    references = {name: value for axis, place in positions.items()
                  for name, value in ((f"{axis}.reference", place), (f"{axis}.reference_rate", 0.0)) if name in inputs}
    beginning = {name: place for axis, place in positions.items()
                 if (name := f"{axis}.position_start") in plant.variables}
    rough = [name for name, variable in plant.variables.items()
             if smooth and name.endswith(SMOOTH) and variable.causality == "parameter"]
    setpoint = ({"setpoint": positions[stage.vertical.name]}
                if controller.name in controllers() and "setpoint" in controller.variables else {})
    controlling = controller.setup(setpoint, asked.controller_parameters)
    return Pair(stage, plant.setup({**beginning, **dict.fromkeys(rough, 0.0)}, asked.plant_parameters), controlling,
                plant.name, controller.name,
                sample_time_of(stage, controller.name, controller.variables, controlling, asked.sample_time), positions,
                signals, commands, references)


def with_fmus(asked: AskedPair, signals: Sequence[str], commands: bool, fmus: str | Path | None, kind: str | None,
              fmi: int) -> AskedPair:
    """Check the names, build missing FMUs, and return the request with the folder of its FMUs.

    `signals` are where its loop is to be opened, with `commands` also at those of phase currents.
    """
    require_names(asked, signals, commands)
    return replace(asked, fmus=fmus_named((asked.plant, asked.controller), asked.stage, fmus, kind, fmi))


def require_names(asked: AskedPair, signals: Sequence[str], commands: bool) -> None:
    """Refuse an unknown signal, axis or parameter, as far as those of this project's plant or controller are known."""
    if asked.stage is not None:
        know_stage(asked.stage)
    for given, known, parameters in ((asked.plant, plants(), asked.plant_parameters),
                                     (asked.controller, controllers(), asked.controller_parameters)):
        if given in known:
            block_of(str(given), parameters or {})
    stage = plants().get(str(asked.plant)) or controllers().get(str(asked.controller))
    if stage is None:
        return
    read_positions(f"Plant{stage.suffix}", asked.at)
    name = f"{name_of(asked.plant)} with {name_of(asked.controller)}"
    openings = openings_of(stage, "phases")
    for signal in signals:
        if commands:
            opening_among(signal, openings, name)
        else:
            measured_among(signal, [opening for opening in openings if opening.endswith("measured")], name)


def part_of(role: str, given: Given, known: Collection[str], fmus: Path, maps: Mapping[str, PortMap]) -> Part:
    """Return a plant or a controller that a user gives, by a known name or by its file."""
    if given in known:
        name = str(given)
        source: Source = FmuFile(current_fmu(name, fmus))
    else:
        if isinstance(given, str) and not (Path(given).suffix or Path(given).exists()):
            otherwise = f"{or_of_own_stage()}, or the path of an FMU or a Python file"
            raise LinearModelError(f"{given!r} is no {role}, expected {one_of(given, known, otherwise)}")
        name, source = name_of(given), source_of(given).copy()
    description = describe(role, source)
    apply(maps.get(role, PortMap()), description)
    return Part(role, name, source, maps.get(role), description)


def pair_wires(stage: StageDescription, parts: Mapping[str, Part]) -> tuple[dict[str, str], tuple[str, ...]]:
    """Outputs of the plant by the inputs of the controller that they go to, and the commands that it takes."""
    signals, commands = {}, []
    for ends in loop_table(stage)["connections"]:
        (giver, _, output), (taker, _, port) = (end.partition(".") for end in ends)
        for role, name, kind in ((giver, output, "output"), (taker, port, "input")):
            known = parts[role].variables
            if name not in known or known[name].causality != kind:
                raise LinearModelError(f"{parts[role].name}: missing port: {kind} {name}, "
                                       f"{nearest(name, known)}; a port map (ports, --map) gives its own names")
        if giver == "plant":
            signals[port] = output
        else:
            commands.append(output)
    return signals, tuple(commands)


def stage_with(variables: Mapping[str, object]) -> StageDescription:
    """The stage whose encoders a plant has as its outputs."""
    for stage in known_stages().stages.values():
        ports = [port.partition(".") for ends in loop_table(stage)["connections"] for port in ends]
        if all(name in variables for role, _, name in ports if role == "plant"):
            return stage
    raise LinearModelError(f"the plant's ports fit none of the stages {', '.join(known_stages().stages)}, expected "
                           "their encoders and commands; a port map (ports, --map) gives its own names")


def read_values(name: str, settings: Settings, description: ModelDescription) -> dict[str, float | bool]:
    """Return values of parameters, SI: checked by the table of this project's FMU, or by another model description."""
    if name in plants() or name in controllers():
        variables = known_stages().definition(name).variables
        known = {v.name: Parameter.of(v) for v in variables if v.causality == "parameter"}
    else:
        known = {v.name: Parameter.described(v) for v in description.modelVariables if v.causality == "parameter"}
    for key in settings:
        require_parameter(key, known, name, LinearModelError)
    return {key: known[key].read(given, f"{name}: {key}", LinearModelError) for key, given in settings.items()}


def sample_time_of(stage: StageDescription, name: str, variables: Mapping[str, object], setup: FmuSetup,
                   given: Quantity | None) -> float:
    """Sample time of a controller, s."""
    if given is not None:
        sample_time = Parameter("s").read(given, f"{name}: sample time", LinearModelError)
    elif setup.ports is not None and setup.ports.step is not None:
        sample_time = setup.ports.step
    elif "sample_time" in setup.start:
        sample_time = float(setup.start["sample_time"])
    else:
        sample_time = float(getattr(variables.get("sample_time"), "start", None) or stage.sample_time)
    if not 0.0 < sample_time < 1.0:
        raise LinearModelError(f"{name}: sample time = {sample_time!r} s, expected one between 0 and 1 s")
    return sample_time


@contextmanager
def resting_pair(pair: Pair, settle: float = SETTLE, strict: bool = True, sign: Sign = no_sign) -> Iterator[Rest]:
    """Run a pair until it rests, for `settle` s at most, and mark both its parts there.

    The controller steps first, as under the master of `maglev run`: with the measurements at t_k, whose commands the
    plant then has until t_k+1. Both call `sign` now and then. LinearModelError if it does not get there or, unless
    `strict` is False, still moves.
    """
    settle = positive_time(settle, LinearModelError, f"settle = {settle!r}")
    steps, look = max(2, round(settle / pair.step)), max(2, round(LOOK / pair.step))
    references = list(pair.references.values())
    with Participant(pair.controller, (*pair.signals, *pair.references), pair.commands, pair.step,
                     sign) as controller, \
            Participant(pair.plant, pair.commands, tuple(pair.signals.values()), pair.step, sign) as plant:
        measured = plant.outputs_now()
        seen: list[list[float]] = []
        given: list[list[float]] = []
        while len(seen) < steps and not (len(seen) > look and np.ptp(seen[-look:], axis=0).max() < CALM):
            for _ in range(min(look, steps - len(seen))):
                seen.append(measured)
                given.append(controller.step([*measured, *references]))
                measured = plant.step(given[-1])
        rows, commands = np.array(seen), np.array(given)
        last = np.array(measured)
        moving = float(np.ptp(rows[-look:], axis=0).max())
        openings = pair.openings
        positions = {axis: round(float(openings[f"{axis}.measured"][0] @ last), 9) for axis in pair.stage.axis_names}
        far = {axis: position - pair.positions[axis] for axis, position in positions.items()}
        worst = max(far, key=lambda axis: abs(far[axis]))
        if abs(far[worst]) > NOT_THERE or (strict and moving > AT_REST):
            raise LinearModelError(
                f"{pair.name}: after {len(rows) * pair.step:g} s {worst} is {1e3 * far[worst]:.4g} mm (mrad) off and "
                f"still moves by {1e6 * moving:.3g} µm (µrad) in half a second, expected a loop at rest: settle "
                "longer, or change the place or the controller")
        controller.mark(np.hstack([rows, np.tile(references, (len(rows), 1))]), commands[-1].tolist())
        plant.mark(commands, measured)
        yield Rest(pair, controller, plant, last, commands[-1], equilibrium_from(pair, positions, commands[-1]), moving)


def equilibrium_from(pair: Pair, positions: dict[str, float], commands: Array) -> Equilibrium:
    """The equilibrium in which a stage rests with phase currents (A) that are commanded."""
    along = tuple((MotorPlaces.of(pair.stage).along @ list(positions.values())).tolist())
    geometries = tuple(pair.stage.motor(motor) for motor in pair.stage.motors)
    by_name = dict(zip(pair.commands, commands.tolist(), strict=True))
    dq = [park(*clarke(*(by_name[f"{name}.i_{phase}_cmd"] for phase in "abc")),
               *sine_cosine(of.electrical_angle(place)))
          for name, of, place in zip(pair.stage.motor_names, geometries, along, strict=True)]
    return Equilibrium(positions, tuple(d for d, _ in dq), tuple(q for _, q in dq), pair.stage, along, geometries)


def apart(function: Callable[..., Found], sources: Sequence[Source], timeout: float, *arguments: Any) -> Found:
    """Call a function here, or where one of the sources that it runs is not of this project, in another process.

    `timeout` is the longest time without a step, s, `TIMEOUT` at least. FmuError if the process dies, or a step takes
    too long. ControllerError if one of the sources is a class, which only this process knows, and another has to run
    elsewhere.
    """
    foreign = [source for source in sources if source.runs_apart]
    if not foreign:
        return function(*arguments)
    for source in sources:
        if isinstance(source, PythonClass):
            raise ControllerError(f"{source}: a class runs in this process only, but {foreign[0].name} runs in another "
                                  "one; give the file of the class")
    names, kind = " or ".join(source.name for source in foreign), hints(function)["return"]
    answer: Found = called_apart(partial(work, function, arguments), names, max(timeout, TIMEOUT), kind)
    return answer


def work(function: Callable[..., Any], arguments: Sequence[Any], send: Send) -> Any:
    """Call the function in this process; each step of its runs is a sign of life."""
    return function(*arguments, sign=partial(send, (0, 1)))
