"""Options of runs, as one record for the command line, signatures, repeated samples of a study, and live links."""

from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, ParamSpec, TypedDict, TypeVar, cast, get_args

from maglev.cosim import Order
from maglev.files.errors import ScenarioError, nearest, one_of, option

if TYPE_CHECKING:
    from maglev.scenario.settings import Settings
    from maglev.user.source import Given

Format = Literal["csv", "parquet"]       # in which the columns of a run are written
KindName = Literal["python", "native"]   # of FMUs of this project, whose results have the same bits
ParameterFiles = str | Path | Mapping[str, str | Path] | Iterable[str | Path] | None

P = ParamSpec("P")
T = TypeVar("T")

REPLACED, NUMERICS, FMUS = "The stage and its controller", "Time and order", "FMUs"   # groups in the help


class Option(NamedTuple):
    """An option of runs, on the command line and in Python."""

    flag: str                         # on the command line
    typed: Any                        # the value as the command line reads it
    help: str
    default: Any = None
    group: str = ""                   # in the help; empty for those that matter first
    metavar: str | None = None        # how the help writes a value
    choices: tuple[Any, ...] = ()     # what it can be, if that is not free
    time: bool = False                # s, or text with a unit
    same_results: bool = False        # bit for bit, whatever it is


class FmuOptions(TypedDict, total=False):
    """Which FMUs of this project run; see `maglev.run`."""

    fmus: Annotated[str | Path | None, Option(
        "--fmus", Path, "Use the FMUs of this folder; build none.", group=FMUS, metavar="FOLDER", same_results=True)]
    kind: Annotated[KindName | None, Option(
        "--kind", KindName, "`native` (with a compiler, the default) or `python`.", group=FMUS, metavar="KIND",
        choices=get_args(KindName), same_results=True)]
    fmi: Annotated[int, Option("--fmi", int, "FMI version of native FMUs, 2 or 3.", 2, FMUS, "N", choices=(2, 3),
                               same_results=True)]


class ControllerOptions(TypedDict, total=False):
    """The controller that replaces that of the plan."""

    controller: Annotated["Given | None", Option(
        "--controller", Path, "Replace the controller: an FMU or a Python file.", metavar="CONTROLLER")]


class PlantOptions(FmuOptions, total=False):
    """The plant that replaces that of the plan, and the values of both."""

    plant: Annotated["Given | None", Option("--plant", Path, "Replace the plant: an FMU or a Python file.",
                                            metavar="PLANT")]
    set: Annotated["Settings", Option("--set", list[str], "Start value in SI or with a unit. Repeatable.",
                                      metavar="FMU.VARIABLE=VALUE")]
    ports: Annotated[str | Path | None, Option(
        "--map", Path, "Names, units and steps of the other FMU's ports.", group=REPLACED, metavar="TOML")]
    keep_settings: Annotated[bool, Option(
        "--keep-settings", bool, "Give your controller the scenario's settings.", False, REPLACED)]
    model: Annotated[str | Path | None, Option(
        "--model", Path, "File of `maglev identify`, or the word `plant`.", group=REPLACED, metavar="TOML")]


class SteppingOptions(TypedDict, total=False):
    """How the FMUs step."""

    step: Annotated[float | str | None, Option("--step", str, "Communication step, in s or with a unit.",
                                               metavar="TIME", time=True)]
    order: Annotated[Order, Option(
        "--order", Order, "`sequential`, or `jacobi`: in parallel.", "sequential", NUMERICS, "ORDER",
        choices=get_args(Order))]


class SingleRunOptions(TypedDict, total=False):
    """Options of single runs, as samples of a study are not."""

    parameters: Annotated[ParameterFiles, Option(
        "--parameters", list[str], "Start values from a parameter set (SSV).", group=REPLACED, metavar="[FMU=]SSV")]
    timeout: Annotated[float | str, Option(
        "--timeout", str, "Time limit of a call of a third-party FMU.", "60 s", NUMERICS, "TIME", time=True)]


class RunOptions(ControllerOptions, PlantOptions, SteppingOptions, SingleRunOptions, total=False):
    """Differences of runs from their plans; see `maglev.run`."""


class CompareOptions(PlantOptions, SteppingOptions, SingleRunOptions, total=False):
    """Options of runs that are compared by their controllers."""


class CheckOptions(ControllerOptions, PlantOptions, SingleRunOptions, total=False):
    """Options of runs that are compared with baselines, which have a step and an order."""


class SampleOptions(ControllerOptions, PlantOptions, SteppingOptions, total=False):
    """Options of the samples of a study, a tuning or a batch."""


SomeOptions = RunOptions | CompareOptions | CheckOptions | SampleOptions

# By name, in the order of the help.
OPTIONS: Mapping[str, Option] = dict(sorted(
    ((name, kind.__metadata__[0]) for name, kind in RunOptions.__annotations__.items()),
    key=lambda pair: ("", REPLACED, NUMERICS, FMUS).index(pair[1].group)))


def completed_options(options: SomeOptions) -> RunOptions:
    """Return options with the defaults of the others, times in s; ScenarioError if one cannot be used."""
    given = {name: value for name, value in options.items() if value is not None}
    for name, value in given.items():
        choices = OPTIONS[name].choices
        if choices and value not in choices:
            raise ScenarioError(f"{option(name, value)}: expected {one_of(str(value), list(map(str, choices)))}")
    completed: dict[str, Any] = {name: given.get(name, option.default) for name, option in OPTIONS.items()}
    return cast("RunOptions", completed | {name: seconds(name, completed[name]) for name, option in OPTIONS.items()
                                           if option.time})


def seconds(name: str, value: float | str | None) -> float | None:
    """Return the value (s) of an option that is a time: a number, or text with a unit."""
    from maglev.files.units import positive_time

    return None if value is None else positive_time(value, ScenarioError, option(name, value))


def with_options(called: Signature, more: Mapping[str, tuple[Any, object]]) -> Signature:
    """Return a signature with options, annotation and default by name, instead of **options."""
    own = [parameter for parameter in called.parameters.values() if parameter.kind is not Parameter.VAR_KEYWORD]
    return called.replace(parameters=[*own, *(
        Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
        for name, (annotation, default) in more.items())])


def takes_options(function: Callable[P, T]) -> Callable[P, T]:
    """Show in the signature of a function with **options what these are, and refuse all others."""
    record, = get_args(function.__annotations__["options"])   # of Unpack
    types = {name: get_args(record.__annotations__[name])[0] for name in OPTIONS if name in record.__annotations__}
    shown = with_options(signature(function), {name: (getattr(kind, "__forward_arg__", kind), OPTIONS[name].default)
                                               for name, kind in types.items()})

    @wraps(function)
    def called(*arguments: P.args, **options: P.kwargs) -> T:
        for name in options.keys() - shown.parameters.keys():
            raise ScenarioError(f"{option(name, options[name])}: not an option of {function.__name__}"
                                if name in OPTIONS else f"{name}: unknown option, {nearest(name, shown.parameters)}")
        for name, value in options.items():
            if shown.parameters[name].annotation is bool and value not in (None, False, True):
                raise ScenarioError(f"{option(name, value)}: expected True or False")
        return function(*arguments, **options)
    called.__signature__ = shown   # type: ignore[attr-defined]  # where inspect, help and editors look
    return called
