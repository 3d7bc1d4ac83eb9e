"""The results of translating a block: its C, and its derivative in Python."""

from collections.abc import Callable, Collection, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from maglev.language.c_text import CText
from maglev.language.constants import constant_attributes
from maglev.language.derivative import Derivatives
from maglev.language.program import FLOAT, Function, Site, Type, ends, functions_of
from maglev.language.python_text import executable
from maglev.language.statements import Program

METHODS: dict[str, tuple[Type, ...]] = {"start": (), "step": (FLOAT, FLOAT)}
CONTINUOUS_METHODS: dict[str, tuple[Type, ...]] = {"derive": (), "settle": ()}
# Methods that have derivatives, by the names of these.
DIFFERENTIATED = {"differentiate": "derive", "differentiate_start": "start", "differentiate_measurement": "measure"}


class BlockText(NamedTuple):
    """A block as C: structs, functions, the values that it starts with as INITIAL, and the functions of its methods."""

    struct: str                       # name of the block's struct
    structs: str
    functions: str                    # with constants and helpers before them
    initial: str
    methods: dict[str, Function]      # by their names, and those that `DIFFERENTIATED` names
    sites: tuple[Site, ...]           # places that can fail in them
    library: frozenset[str]           # functions of <math.h> that they call
    ends: bool                        # true if every call comes to an end, whatever the values


def block_text(block: Any, continuous: bool = False, prefix: str = "", careful: Collection[str] = (),
               reserved: Collection[str] = (), settable: Collection[str] | None = None) -> BlockText:
    """The C of a block with `start` and `step`, and of a continuous one with `derive`, `settle` and derivatives.

    Struct names begin with `prefix`. With the paths of all that is assigned from outside, `settable`, other whole
    numbers and Booleans that no method assigns are constants. For `careful`, `reserved` and the errors see `Program`.
    """
    program = Program(block, careful, reserved, prefix)
    methods = {name: program.method(name, types)
               for name, types in (METHODS | (CONTINUOUS_METHODS if continuous else {})).items()}
    if continuous:
        derivatives = Derivatives(rules(program))
        methods |= {name: derivatives.of(program.method(method, ())) for name, method in DIFFERENTIATED.items()}
    constants = {} if settable is None else constant_attributes(
        program.layout, block, functions_of(list(methods.values())), settable)
    text = CText(program.layout, list(methods.values()), constants)
    return BlockText(program.layout.root.name, text.structs(), text.functions_text(), text.initial(block, "INITIAL"),
                     methods, tuple(program.sites), frozenset(text.library), ends(text.functions))


def rules(program: Program) -> dict[str, Function]:
    """Return the functions of the program, by name, that rules of derivatives may call."""
    return {function.source.__name__: function for function in program.functions.values()
            if "." not in function.source.__qualname__}


def shape(block: Any) -> tuple[Any, ...]:
    """Return the properties that the program of a block depends on: classes and types of attributes, parts included."""
    layout = Program(block).layout
    return layout.root, *((layout.classes[name], *fields.items()) for name, fields in layout.fields.items())


class Shaped:
    """A block that is equal to others of its shape."""

    def __init__(self, block: Any):
        self.block = block
        self.key = shape(block)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Shaped) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)


def derivative(block: Any, method: str, arguments: Sequence[Type] = ()) -> Callable[..., Any]:
    """Return a function that computes a method and its derivative along a direction.

    It takes the block and a second one with its derivatives, and after each argument its derivative. Untranslatable if
    the method is not in the language of blocks, or has no derivative.
    """
    return derivative_of(Shaped(block), method, tuple(arguments))


@lru_cache(maxsize=64)
def derivative_of(shaped: Shaped, method: str, arguments: tuple[Type, ...]) -> Callable[..., Any]:
    program = Program(shaped.block)
    function = program.method(method, arguments)
    made = Derivatives(rules(program))
    root = made.of(function)
    return executable(root, {id(function) for function in made.made.values()})
