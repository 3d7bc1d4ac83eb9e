"""FMUs that replace those of a run: the ports that they lack, the parts left out for that, and the notes on it."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from fmpy.model_description import ModelDescription

from maglev.cosim.fmi_versions import OWN_TOOL
from maglev.cosim.open import describe
from maglev.cosim.port_map import PortMap, apply
from maglev.descriptions.own_fmus import definition
from maglev.descriptions.registry import known_stages
from maglev.files.errors import ScenarioError, UnknownName, few, nearest, option
from maglev.files.units import known_unit
from maglev.scenario.claims import RunClaim
from maglev.scenario.run_plan import Motor, RunPlan, StartValue
from maglev.user.source import FmuFile, Given, Source, file_source, source_of

LACKING = "it has no such variable"
SETTING = "it is a setting of"   # and the model's name


@dataclass(frozen=True)
class Replacement:
    """Source that replaces an FMU of a run, its names for the ports, and whether it gets the settings of that FMU."""

    source: Source
    ports: PortMap = field(default_factory=PortMap)
    keep_settings: bool = False

    def description(self, name: str) -> ModelDescription:
        """Model description with our names and SI units."""
        description = describe(name, self.source)
        apply(self.ports, description)
        return description


def known_ports(plan: RunPlan, name: str) -> dict[str, str | None]:
    """Return the known variables of an FMU of a run, with units: those named in the run, and those of our FMUs."""
    optional = [port.partition(".")[2] for _, port in optional_ports(plan, name)]
    known: dict[str, str | None] = dict.fromkeys([*essential_ports(plan, name), *optional, *plan.fmus[name].start])
    for signal in plan.signals:
        if signal.unit is not None and signal.to.startswith(f"{name}."):
            known[signal.to.partition(".")[2]] = unit.si if (unit := known_unit(signal.unit)) else signal.unit
    model, file = plan.fmus[name].model, plan.fmus[name].file
    source = None if file is None else file_source(file)
    if model in known_stages().definitions():
        known |= {variable.name: variable.unit or None for variable in definition(model).variables}
    elif source is not None and source.path.is_file():
        known |= {variable.name: variable.unit for variable in describe(name, source).modelVariables}
    return known


def named_or_source(role: str, given: Given, plans: Iterable[RunPlan]) -> str | Source:
    """Name of an FMU of this project, or source of another block, that replaces the plant or the controller of runs.

    A bare name means an FMU if no file has it; UnknownName, with the nearest of the stages of the runs, if there is no
    such FMU.
    """
    if not isinstance(given, str | Path) or not str(given) == Path(given).name == Path(given).stem or (
            Path(given).exists()):
        return source_of(given)
    known = known_stages().definitions()
    if str(given) not in known:
        suffixes = tuple(plan.stage.suffix for plan in plans if plan.stage is not None)
        names = [name for name in known if name.endswith(suffixes)] or known
        raise UnknownName(f"{role} {given}: is no FMU of this project and no file, "
                          f"{nearest(given, names, '.py', '.fmu')}")
    return str(given)


def given_and_left_out(plan: RunPlan, name: str, replacement: Replacement,
                       put_in: bool) -> tuple[dict[str, StartValue], dict[str, str]]:
    """Start values of the plan that an FMU gets, and why it does not get the others, or a signal, by variable.

    Conditions of the experiment are for every FMU that has such a variable. Settings of a design are for the model
    that the plan names; this project's models share what their settings mean, and so their settings. The FMU is one
    that was put in, or one that a scenario names in the place of another one.
    """
    planned = plan.fmus[name]
    own = {} if put_in else planned.start
    theirs = {**planned.inherited, **planned.start} if put_in else planned.inherited
    driven = [signal.to.removeprefix(f"{name}.") for signal in plan.signals if put_in]
    shared = replacement.keep_settings or ((planned.file is None) == put_in and replacement.source.built_here)
    variables = {variable.name: variable for variable in replacement.description(name).modelVariables}
    left_out = {variable: LACKING for variable in [*own, *theirs, *planned.start_from] if variable not in variables}
    if not shared and name not in plan.plants:
        left_out |= {variable: f"{SETTING} {planned.model or 'what it takes the place of'}"
                     for variable in [*theirs, *planned.start_from, *driven]
                     if variable in variables and variable not in own
                     and variables[variable].causality == "parameter"}
    return {variable: value for variable, value in {**theirs, **own}.items() if variable not in left_out}, left_out


def start_value_notes(plan: RunPlan, sources: Mapping[str, Source], left_out: Mapping[str, str],
                      put_in: Sequence[str]) -> Iterator[str]:
    """Return sentences about the start values that replaced FMUs get, and those that they do not get.

    Authors of a Python controller know its own values, so only names that both have are mentioned for it.
    """
    for name, source in sources.items():
        lacking = [full for full, reason in left_out.items() if reason == LACKING and full.startswith(f"{name}.")]
        if lacking and isinstance(source, FmuFile):
            yield f"{has_no(name, source, lacking, few)}: the plan's start values are left out"
        own = [full for full, reason in left_out.items() if reason != LACKING and full.startswith(f"{name}.")]
        if own:
            yield (f"{name} ({source.name}) keeps its own {few(own)}: the plan's values are settings of"
                   f"{left_out[own[0]].removeprefix(SETTING)}"
                   + (f"; {option('keep_settings', True)} gives them" if name in put_in else ""))
        given = [f"{variable} = {value.written}" for variable, value in plan.fmus[name].start.items()]
        if name in put_in and (given or isinstance(source, FmuFile)):
            yield f"{name} ({source.name}) starts with {', '.join(given) or 'its own values'}"


def has_no(name: str, source: Source, lacking: Sequence[str], shown: Callable[[list[str]], str] = ", ".join) -> str:
    """Say what a participant of a run lacks, variables `fmu.variable`."""
    return f"{name} ({source.name}) has no {shown([full.removeprefix(f'{name}.') for full in lacking])}"


def essential_ports(plan: RunPlan, name: str) -> dict[str, str]:
    """Causalities of the variables of an FMU without which a run means nothing, by name."""
    ports = {}
    for source, target in plan.wires.values():
        ports[source], ports[target] = "output", "input"
    ports |= {signal.to: "input" for signal in plan.signals}
    for axis in plan.axes.values():
        ports.setdefault(axis.position, "output")
        ports.setdefault(axis.reference, "input")
    return {port.partition(".")[2]: causality for port, causality in ports.items() if port.startswith(f"{name}.")}


def optional_ports(plan: RunPlan, name: str) -> list[tuple[str, str]]:
    """Return the ports of an FMU that a run can do without, `fmu.variable`, each with a word for the missing part."""
    ports = [(key, flag) for key, flag in (("stop contact", plan.stop_flag), ("trip", plan.trip_flag)) if flag]
    ports += [("rate", signal.rate_to) for signal in plan.signals if signal.rate_to is not None]
    ports += [("comparison", signal) for signal in plan.check.signals]
    for motor in plan.motors.values():
        ports += [("currents", port) for port in motor.currents] + [("commands", port) for port in motor.commands]
    return [(what, port) for what, port in ports if port.startswith(f"{name}.")]


def require_essential(plan: RunPlan, put_in: Mapping[str, Source],
                      descriptions: Mapping[str, ModelDescription]) -> None:
    """Refuse FMUs that were put in and lack essential ports: all of these in one message, with the nearest names."""
    for name, source in put_in.items():
        missing = missing_ports(plan, name, descriptions[name])
        if not missing:
            continue
        needed, lines = essential_ports(plan, name), []
        for port, causality in missing.items():
            free = [v.name for v in descriptions[name].modelVariables
                    if v.causality == causality and v.name not in needed]
            lines.append(f"{causality} {port}" + (f" ({nearest(port, free)})" if free else ""))
        tables = dict.fromkeys(f"{causality}s" for causality in missing.values())
        place = "" if isinstance(source, FmuFile) else " and ".join(
            f"the table of {source.place_of(table)}" for table in tables)
        raise ScenarioError(f"{name} ({source.name}): missing port{'s' if len(missing) > 1 else ''}: "
                            f"{', '.join(lines)}; expected these names{f' in {place}' if place else ''}, or a port map "
                            "(ports, --map) with the FMU's own (docs/importing.md)")


def missing_ports(plan: RunPlan, name: str, description: ModelDescription) -> dict[str, str]:
    """Causalities of the essential ports that an FMU lacks, by name."""
    variables = {variable.name for variable in description.modelVariables}
    return {port: causality for port, causality in essential_ports(plan, name).items() if port not in variables}


def fit(plan: RunPlan, replaced: Mapping[str, Replacement]) -> tuple[RunPlan, list[str]]:
    """Leave out of a run what FMUs that were put in, by name in it, lack, as far as it can do without.

    Returns the plan, and sentences about it for the user. A signal to compare that FMUs of this project lack, too, is
    misspelt, and stays to be refused.
    """
    notes: list[str] = []
    for name, replacement in replaced.items():
        description, known = replacement.description(name), replacement.ports.units
        if missing_ports(plan, name, description):
            continue   # refused before it runs, with all of them
        variables = {variable.name for variable in description.modelVariables}
        lacking = [(what, port) for what, port in optional_ports(plan, name) if port.partition(".")[2] not in variables
                   and (what != "comparison" or port.partition(".")[2] in known)]
        if lacking:
            says = partial(has_no, name, replacement.source)
            plan = without(plan, lacking, says)
            # A controller written by a user without a flag for a trip does not trip.
            told = dict.fromkeys(port for what, port in lacking
                                 if what != "trip" or isinstance(replacement.source, FmuFile))
            if told:
                notes.append(f"{says([*told])}: metrics and claims that need them are left out")
        notes += remarks(plan, name, replacement, description, known)
    return plan, notes


def remarks(plan: RunPlan, name: str, replacement: Replacement, description: ModelDescription,
            known: Mapping[str, object]) -> Iterator[str]:
    """Return notes on an FMU that can run: inputs without a source, and another step that it names."""
    fed = {target for _, target in plan.wires.values()} | {signal.to for signal in plan.signals}
    extra = [v.name for v in description.modelVariables
             if v.causality == "input" and v.type != "Clock" and f"{name}.{v.name}" not in fed and v.name not in known]
    if extra:
        yield (f"nothing feeds {', '.join(f'{name}.{port}' for port in extra)}: "
               + ("they keep their start values" if len(extra) > 1 else "it keeps its start value"))
    own = (description.generationTool or "").startswith(OWN_TOOL)
    named = getattr(description.defaultExperiment, "stepSize", None)
    fixed = not description.coSimulation.canHandleVariableCommunicationStepSize
    asked = replacement.ports.step
    if not own and fixed and asked is None and named is not None and abs(float(named) - plan.step) > 1e-9:
        yield (f"{name} ({replacement.source.name}) has a fixed step of {float(named):g} s, but gets the communication "
               f"step; step = ... under [{name}] of a port map (ports, --map) changes that")


def without(plan: RunPlan, lacking: Sequence[tuple[str, str]], says: Callable[[list[str]], str]) -> RunPlan:
    """Return the plan without ports, each given with its purpose; claims that need them become not testable, with
    `says`.
    """
    ports = {port for _, port in lacking}
    signals = [signal.model_copy(update={"rate_to": None}) if signal.rate_to in ports else signal
               for signal in plan.signals]
    motors = {name: Motor(currents=all_or_none(motor.currents, ports), commands=all_or_none(motor.commands, ports))
              for name, motor in plan.motors.items()}
    compared = {name: tolerance for name, tolerance in plan.check.signals.items() if name not in ports}
    return plan.model_copy(update={
        "check": plan.check.model_copy(update={"signals": compared}), "signals": signals, "motors": motors,
        "stop_flag": None if plan.stop_flag in ports else plan.stop_flag,
        "trip_flag": None if plan.trip_flag in ports else plan.trip_flag,
        "claims": [judgeable(claim, plan, lacking, says) for claim in plan.claims]})


def all_or_none(names: Sequence[str], lacking: Iterable[str]) -> list[str]:
    """The names, none if one of them is lacking: a peak of the others would pass for that of all."""
    return [] if set(names) & set(lacking) else list(names)


def judgeable(claim: RunClaim, plan: RunPlan, lacking: Sequence[tuple[str, str]],
              says: Callable[[list[str]], str]) -> RunClaim:
    """The claim, not testable if its metric needs what is lacking."""
    needed = claim.measured.recorded if claim.measured else ""
    names = {port for what, port in lacking if what == needed}
    if needed in ("currents", "commands"):
        names &= {port for name in claim.motors or plan.motors for port in getattr(plan.motors[name], needed)}
    if not names:
        return claim
    return claim.model_copy(update={"quantity": None, "than": None, "than_axis": None,
                                    "not_testable": says(sorted(names))})
