"""A block as freestanding C99 for a microcontroller: one header with its ports, one source, no library, no memory.

The translated modules of the block become one file of static functions, without uncalled ones. Three functions,
`NAME_init`, `NAME_start`, `NAME_sample`, enclose it and do the work of an FMU: ranges are checked, times counted.
"""

from collections.abc import Collection, Iterable
from math import isfinite
from pathlib import Path
from textwrap import wrap

from maglev.fmi.block_code import FIRST_FAILURE, c_path
from maglev.fmi.definition import SAMPLE_TIME, FmuDefinition, Variable
from maglev.fmi.escapes import c_comment
from maglev.fmi.templates import filled
from maglev.language.blocks import BlockText, block_text
from maglev.language.c_text import c_literal
from maglev.language.errors import ExportError

# Functions in arithmetic.h.
KNOWN = {"fabs", "sqrt", "isfinite"}

C_FILES = Path(__file__).with_name("target")

WIDTH = 120            # of a line
REFUSED_VALUE = 1000   # status: this and the number of a variable that is no number within its range

ABOUT = """\
{name}: {description}.

Call {name}_sample every {period} s (sample_time): it takes inputs and gives outputs, all in SI units. Before that,
{name}_init sets all parameters to the values below, and {name}_start computes the quantities that follow from them.
Parameters can be set between these calls, and tunable ones also later. Each function returns 0, or the status of a
refusal: a refused sample is not taken, and its outputs do not change. The code needs no library and allocates no
memory. Several controllers share nothing.

{maker}, of the source of the FMU of this name, with its bits if the compiler neither contracts a product and a sum
(-ffp-contract=off) nor is told to be fast (-ffast-math)."""


def ports_of(definition: FmuDefinition) -> tuple[tuple[Variable, ...], tuple[Variable, ...]]:
    """Variables as the host of a board sees them, in the order of its tables: those to set, those to read."""
    return (tuple(v for v in definition.variables if v.causality in ("input", "parameter")),
            tuple(v for v in definition.variables if v.causality == "output"))


def freestanding(definition: FmuDefinition, careful: Collection[str], maker: str) -> dict[str, str]:
    """C files by name: NAME.h and NAME.c, an example over them, a file for CMake, and a board in QEMU to run it on.

    `careful` are packages whose code checks values before it divides; `maker` stands in the header. ExportError if the
    block does not sample, calls functions of a mathematical library, or two of its ports become one name.
    Untranslatable if it is not in the language of blocks.
    """
    if not definition.sampled:
        raise ExportError(f"{definition.name}: has no {SAMPLE_TIME}, expected a controller, or another block that "
                          "samples")
    name, (settable, readable) = definition.name, ports_of(definition)
    inputs = tuple(v for v in settable if v.causality == "input")
    for chosen in (inputs, readable):
        if len(set(map(member, chosen))) < len(chosen):
            raise ExportError(f"{name}: two of {', '.join(v.name for v in chosen)} have one name in C, expected names "
                              "that differ by more than a dot")
    text = code_of(definition, careful)
    sampling = next(v for v in definition.variables if v.name == SAMPLE_TIME)
    period = repr(definition.start_value(sampling))
    common = {"NAME": name, "SPACE": " " * len(name), "PERIOD": period, "STRUCT": text.struct}
    about = ABOUT.format(name=name, description=definition.description.rstrip("."), period=period, maker=maker)
    values = {
        f"{name}.h": {
            "ABOUT": listed(about.replace("\n\n", "\0").replace("\n", " ").replace("\0", "\n\n").split("\n"), 1, 116),
            "GUARD": f"{name.upper()}_H", "INPUTS": members(inputs), "OUTPUTS": members(readable),
            "PARAMETERS": listed(parameter_line(definition, v, k) for k, v in enumerate(definition.variables)
                                 if v.causality == "parameter"),
            "STATUSES": listed([*(f"{status:4}  {words}" for status, words in sorted(definition.refusals.items())),
                                *(f"{FIRST_FAILURE + site.number}  {site.text}" for site in text.sites),
                                f"{REFUSED_VALUE} and the number of a variable: it is no number within its range"]),
            "STRUCTS": text.structs},
        f"{name}.c": {
            "ARITHMETIC": template("arithmetic.h"), "FUNCTIONS": text.functions, "INITIAL": f"static {text.initial}",
            "START": called(text, "start", "block"), "STEP": called(text, "step", "block, self->samples * step, step"),
            "FAILED": str(FIRST_FAILURE),
            "CHECKED_PARAMETERS": checks(definition, "parameter"), "CHECKED_INPUTS": checks(definition, "input"),
            "TAKEN": "\n".join(f"    block->{c_path(v.place)} = inputs->{member(v)};" for v in inputs),
            "GIVEN": "\n".join(f"    outputs->{member(v)} = block->{c_path(v.place)};" for v in readable),
            "SAMPLE_TIME": c_path(sampling.place),
            "FINITE": finite(definition)},
        "qemu/table.h": {
            "SETTABLE": place_rows(text.struct, ((c_path(v.place), v) for v in settable)),
            "READABLE": place_rows(text.struct, ((c_path(v.place), v) for v in readable)),
            "OUTPUTS": place_rows(f"{name}_outputs", ((member(v), v) for v in readable)),
            "INPUTS": "\n".join(f"    {{{place_row(f'{name}_inputs', member(v), v)}, {k}}},"
                                for k, v in enumerate(settable) if v.causality == "input")},
        **{file: {} for file in ("main.c", "board.h", "CMakeLists.txt", "qemu/board_qemu.c", "qemu/mps2_an500.ld")}}
    return {file: filled(C_FILES / file.replace(f"{name}.", "controller."), common | own)
            for file, own in values.items()}


def code_of(definition: FmuDefinition, careful: Collection[str]) -> BlockText:
    """The block as C, with names that a program can have next to others."""
    text = block_text(definition.new_block(), prefix=f"{definition.name}_", careful=careful,
                      settable=[v.place for v in definition.native_variables])
    if wanted := text.library - KNOWN:
        raise ExportError(f"{definition.name}: calls {' and '.join(sorted(wanted))}, which a processor without a "
                          "mathematical library does not have, expected functions of pmlsm, such as "
                          "sine_cosine")
    return text


def called(text: BlockText, method: str, arguments: str) -> str:
    """Call of a method of the block, which notes failures in it."""
    function = text.methods[method]
    return f"{function.name}({arguments}{', &failure' if function.fails else ''})"


def finite(definition: FmuDefinition) -> str:
    """Refusals of outputs that are no finite numbers."""
    return "".join(f"    if (!isfinite(block->{c_path(place)})) {{\n        return {status};\n    }}\n"
                   for status, place in definition.finite)


def template(name: str) -> str:
    return (C_FILES / name).read_text(encoding="utf-8")


def member(variable: Variable) -> str:
    """A port as a member of a structure."""
    return variable.name.replace(".", "_")


def members(variables: Iterable[Variable]) -> str:
    """Members of a structure of ports, with units and descriptions."""
    rows = [(f"    {'bool' if v.boolean else 'double'} {member(v)};", v) for v in variables]
    width = max((len(declared) for declared, _ in rows), default=0)
    lines = []
    for declared, v in rows:
        about = c_comment(", ".join(filter(None, (v.unit, v.description))))
        beside = f"{declared:{width}}   /* {about} */"
        above = [f"    /* {part} */" for part in wrap(about, WIDTH - 10)]
        lines += [beside] if len(beside) <= WIDTH else [*above, declared]
    return "\n".join(lines)


def parameter_line(definition: FmuDefinition, variable: Variable, number: int) -> str:
    """Number of a parameter, its place, its value and unit, and its meaning."""
    value = definition.start_value(variable)
    shown = " ".join(filter(None, (str(value).lower() if variable.boolean else repr(value), variable.unit)))
    tunable = ", tunable" if variable.variability == "tunable" else ""
    return f"{number:4}  block.{variable.place} = {shown}: {variable.description}{tunable}"


def listed(lines: Iterable[str], indent: int = 3, width: int = 112) -> str:
    begin, further = f" *{' ' * indent}", " " * 3 * (indent - 1)
    return "\n".join(f"{begin}{part}".rstrip() for line in lines
                     for part in wrap(c_comment(line), width, subsequent_indent=further) or [""])


def checks(definition: FmuDefinition, causality: str) -> str:
    """Refusals of values that are no numbers within their range."""
    lines = []
    for number, v in enumerate(definition.variables):
        if v.causality == causality and not v.boolean:
            value = f"inputs->{member(v)}" if causality == "input" else f"block->{c_path(v.place)}"
            limits = [f"{value} {sign} {c_literal(float(bound))}" for sign, bound in ((">=", v.low), ("<=", v.high))
                      if isfinite(bound)]
            fits = limits if len(limits) == 2 else [f"isfinite({value})", *limits]
            lines += [f"    if (!({' && '.join(fits)})) {{", f"        return {REFUSED_VALUE + number};", "    }"]
    return "\n".join(lines)


def place_row(struct: str, path: str, variable: Variable) -> str:
    """Initialiser of a row of a table of places."""
    return f"{{offsetof(struct {struct}, {path}), {'true' if variable.boolean else 'false'}}}"


def place_rows(struct: str, members: Iterable[tuple[str, Variable]]) -> str:
    return "\n".join(f"    {place_row(struct, path, variable)}," for path, variable in members)
