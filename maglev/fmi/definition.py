"""Definition of an FMU: a block and the table of its variables. Everything else is derived from these."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from math import inf
from sys import float_info
from typing import Any

SAMPLE_TIME = "sample_time"   # parameter of a block that samples: its interval


PART = re.compile(r"(?:^|\.)(\w+)|\[(\d+)\]")   # of a path in a block: an attribute, or an element of a list
PATH = re.compile(r"\w+(?:\.\w+|\[\d+\])*")

Slot = tuple[Any, str | int]   # an object and the name of an attribute, or a list and the number of an element


def slot(block: Any, place: str) -> Slot:
    """Object or list of a block, and attribute or element of it, at a path such as "axes[0].observer.position"."""
    *parts, last = [int(number) if number else name for name, number in PART.findall(place)]
    for part in parts:
        block = look(block, part)
    return block, last


def look(owner: Any, key: str | int) -> Any:
    """Value of an attribute, or of an element of a list."""
    return owner[key] if isinstance(key, int) else getattr(owner, key)


def put(owner: Any, key: str | int, value: Any) -> None:
    """Assign to an attribute, or to an element of a list."""
    if isinstance(key, int):
        owner[key] = value
    else:
        setattr(owner, key, value)


def read(block: Any, place: str) -> Any:
    """Value at a path of a block."""
    return look(*slot(block, place))


def write(block: Any, place: str, value: Any) -> None:
    """Assign to a path of a block."""
    put(*slot(block, place), value)


def reader(places: Sequence[str]) -> Callable[[Any], tuple[Any, ...]]:
    """Return a function that reads paths of a block in one call, which is faster than one after the other."""
    wrong = [place for place in places if not PATH.fullmatch(place)]
    if wrong:
        raise ValueError(f"{wrong[0]!r}: expected a path such as axes[0].measured")
    values = "".join(f"block.{place}, " for place in places)
    function: Callable[[Any], tuple[Any, ...]] = eval(f"lambda block: ({values})")
    return function


@dataclass(frozen=True)
class Variable:
    """One FMI variable: a value of the block, with the facts that a user must know about it.

    The start value is the one that a new block has. Minimum and maximum are enforced on inputs and parameters.
    """

    name: str                              # and attribute path of the block, if there is no `path`
    causality: str                         # input, output, parameter, or local in a continuous model
    variability: str                       # continuous, discrete, tunable or fixed
    description: str
    unit: str = ""                         # made of `units.SYMBOLS`; "" for Booleans and ratios
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    source: str = ""                       # of a parameter's start value: page, table, or "assumed"
    depends_on: tuple[str, ...] = ()       # inputs at a sample that decide this output for the step after it
    starts_from: tuple[str, ...] = ()      # parameters that decide this output's initial value
    boolean: bool = False
    path: str = ""                         # attribute path of the block where it is not the name
    hint: str = ""                         # advice for a value that is out of range

    @property
    def place(self) -> str:
        """Attribute path of the block."""
        return self.path or self.name

    def slot(self, block: Any) -> Slot:
        """Object or list of a block that holds it, and the attribute or element of that."""
        return slot(block, self.place)

    def read(self, block: Any) -> Any:
        """Value that a block has."""
        return read(block, self.place)

    def write(self, block: Any, value: Any) -> None:
        """Give a block a value."""
        write(block, self.place, value)

    @property
    def low(self) -> float:
        """Minimum, -inf if there is none."""
        return -inf if self.minimum is None else self.minimum

    @property
    def high(self) -> float:
        """Maximum, inf if there is none."""
        return inf if self.maximum is None else self.maximum

    @property
    def settable(self) -> tuple[float, float]:
        """Least and largest value that it can be set to: finite ones."""
        return max(self.low, -float_info.max), min(self.high, float_info.max)

    @property
    def hinted(self) -> str:
        """End of a message about a value that is out of range."""
        return f"; {self.hint}" if self.hint else ""


@dataclass(frozen=True)
class DefaultExperiment:
    """Default experiment: stop time and communication step, s; many tools step a 500th of the stop time instead."""

    stop_time: float
    step: float


@dataclass(frozen=True)
class State:
    """A continuous state: names of its variable, of its derivative, and of states and inputs that decide the latter."""

    variable: str
    derivative: str
    depends_on: tuple[str, ...]
    jumps: bool = False   # at an event


@dataclass(frozen=True)
class ContinuousModel:
    """A block as a system of differential equations, for Model Exchange.

    The block has three methods. `derive() -> int` computes all continuous values at the present point and returns a
    status, like `step`. `settle() -> bool` takes in an event and returns True if a state jumps. `measure()` sets the
    real outputs that change at events. A native FMU has the variables after those of the definition.
    """

    states: tuple[State, ...]
    variables: tuple[Variable, ...]              # local: states and rates that are no outputs, and indicators
    indicators: Mapping[str, tuple[str, ...]]    # states and inputs on which an event indicator depends
    outputs: Mapping[str, tuple[str, ...]]       # states and inputs that decide an output, by its name


@dataclass(frozen=True)
class Drawing:
    """A function that draws an icon (`icon.Shape`s) or a sketch (SVG), called with numbers or words.

    It has the name of its module, not the module itself, so that an FMU in Python does not carry it.
    """

    module: str
    function: str
    arguments: tuple[int | str, ...] = ()

    def drawn(self) -> Any:
        """Return the drawing of the function."""
        return getattr(import_module(self.module), self.function)(*self.arguments)


@dataclass(frozen=True)
class Array:
    """An array of FMI 3.0: the names of the variables that are its elements, row by row."""

    name: str
    description: str
    shape: tuple[int, ...]
    elements: tuple[str, ...]


@dataclass(frozen=True)
class FmuDefinition:
    """A block as an FMU.

    The block has `start() -> int`, called when the parameters are set, and `step(t, dt) -> int`; both return 0, or
    the key of a text in `refusals`. A text may name variables in braces, and {time} and {step}.
    """

    name: str
    block: type
    description: str
    variables: tuple[Variable, ...]
    refusals: Mapping[int, str]
    experiment: DefaultExperiment
    variable_step: bool = False                        # any communication step, changing ones as well
    documentation: tuple[tuple[str, str], ...] = ()    # (package, file in its folder `documentation`)
    icon: Drawing | None = None
    sketch: Drawing | None = None                      # first drawing of the documentation
    arguments: tuple[Any, ...] = ()                    # of the block's constructor, such as the law of a regulator
    slave: tuple[str, str] = ("maglev.fmi.slave", "BlockSlave")   # module and class, of an FMU that runs in Python
    author: str = "Maglev FMUs contributors"           # "" if the block has another author and another licence
    requires: tuple[str, ...] = ()                     # packages of the importer's Python that the block needs
    continuous: ContinuousModel | None = None          # of a native FMU that is for Model Exchange as well
    sampled: bool = False                              # at the start, and then every SAMPLE_TIME
    clocked: bool = False                              # one of FMI 3.0 samples when the importer's clock ticks
    finite: tuple[tuple[int, str], ...] = ()           # status, and attribute path, of outputs that have to stay finite
    fed: tuple[str, ...] = ()                          # tunable parameters that became inputs
    was: str = ""                                      # its name before they did
    arrays: tuple[Array, ...] = ()                     # of FMI 3.0; in FMI 2.0 their elements are variables

    @property
    def native_variables(self) -> tuple[Variable, ...]:
        return self.variables if self.continuous is None else (*self.variables, *self.continuous.variables)

    @property
    def sampling(self) -> str:
        """Attribute path of the sample time of a block that takes whole steps of it; empty if any step fits."""
        places = (v.place for v in self.variables if v.name.rpartition(".")[2] == SAMPLE_TIME)
        return "" if self.variable_step else next(places, "")

    def new_block(self) -> Any:
        return self.block(*self.arguments)

    def start_value(self, variable: Variable) -> float | bool:
        """Value that a new block gives a variable."""
        value: float | bool = variable.read(self.new_block())
        return value


def with_inputs(definition: FmuDefinition, name: str, parameters: Sequence[str]) -> FmuDefinition:
    """Return the definition under another name, with tunable parameters as inputs, for masters that set only inputs.

    They may be 0, for some masters begin with that. All outputs of a step are taken to depend on them.
    """
    def changed(variable: Variable) -> Variable:
        if variable.name in parameters:
            low = None if variable.minimum is None else min(variable.minimum, 0.0)
            return replace(variable, causality="input", source="", minimum=low,
                           variability="discrete" if variable.boolean else "continuous")
        if variable.causality == "output" and variable.depends_on:
            return replace(variable, depends_on=(*variable.depends_on, *parameters))
        return variable

    return replace(definition, name=name, variables=tuple(map(changed, definition.variables)), fed=tuple(parameters),
                   was=definition.name)


def parameter(name: str, unit: str, description: str, source: str, minimum: float, maximum: float,
              nominal: float | None = None, fixed: bool = False, hint: str = "") -> Variable:
    """Real parameter; a fixed one feeds a computation at initialisation, others act at the next step."""
    return Variable(name, "parameter", "fixed" if fixed else "tunable", description, unit,
                    minimum, maximum, nominal, source, hint=hint)


def switch(name: str, description: str, source: str, fixed: bool = False) -> Variable:
    """Boolean parameter, tunable if not fixed."""
    return Variable(name, "parameter", "fixed" if fixed else "tunable", description, source=source, boolean=True)


def real_input(name: str, unit: str, description: str, bound: float, nominal: float) -> Variable:
    """Real input, within ±bound."""
    return Variable(name, "input", "continuous", description, unit, -bound, bound, nominal)


def real_output(name: str, unit: str, description: str, nominal: float, discrete: bool = False,
                depends_on: tuple[str, ...] = (), starts_from: tuple[str, ...] = ()) -> Variable:
    """Real output; a discrete one is constant between events."""
    return Variable(name, "output", "discrete" if discrete else "continuous", description, unit,
                    nominal=nominal, depends_on=depends_on, starts_from=starts_from)


def flag(name: str, description: str, depends_on: tuple[str, ...] = ()) -> Variable:
    """Boolean output."""
    return Variable(name, "output", "discrete", description, depends_on=depends_on, boolean=True)
