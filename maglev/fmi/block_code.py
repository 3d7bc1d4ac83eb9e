"""C of an FMU: the block as one header, with its possible failures, and the table of variables for the FMI layer."""

import re
from collections.abc import Collection, Iterable
from pathlib import Path
from textwrap import wrap
from typing import NamedTuple

from maglev.fmi.definition import FmuDefinition, Variable
from maglev.fmi.escapes import c_string
from maglev.fmi.templates import filled
from maglev.language.blocks import BlockText, block_text
from maglev.language.c_text import c_literal
from maglev.language.names import identifier
from maglev.language.program import Function

# C files, most of which have places for text that follows from a block.
TEMPLATES = Path(__file__).with_name("native_templates")
BLOCK, TABLE = "block.h", "model.c"   # in the sources of an FMU
FIRST_FAILURE = 1_000_000        # status: this and the number of the place that failed; one of the C layer, too

# Signatures of the functions around a block, and how they call the block's own functions.
WRAPPED = {"start": ("int64_t start_block(void *block)", ""),
           "step": ("int64_t step_block(void *block, double time, double size)", ", time, size"),
           "derive": ("int64_t derive_block(void *block)", ""),
           "settle": ("bool settle_block(void *block)", ""),
           "differentiate": ("int64_t differentiate_block(void *block, void *direction)", ", direction"),
           "differentiate_start": ("int64_t differentiate_start_block(void *block, void *direction)", ", direction"),
           "differentiate_measurement": ("void differentiate_measurement_block(void *block, void *direction)",
                                         ", direction")}

# Names that a header which is written here defines: of structs, and of all else at the beginning of a line.
STRUCT = re.compile(r"^struct (\w+) \{", re.MULTILINE)
DEFINED = re.compile(r"^(?:typedef struct \w+ (\w+);|enum \{ (\w+)|static [\w *]*?\b(\w+)(?=\(| =|\[))", re.MULTILINE)

# The independent variable of FMI 3.0, after the others: where the next communication step starts.
TIME_ROW = """\
    {"time", "s", offsetof(struct RunState, progress.next_time), false, false, false, INDEPENDENT, -INFINITY,
     INFINITY, ""},"""


def c_path(place: str) -> str:
    """An attribute path, such as "motors[0].i_a", in C."""
    return ".".join(re.sub(r"^[^\[]+", lambda name: identifier(name[0]), part) for part in place.split("."))


class BlockCode(NamedTuple):
    """Text of the header BLOCK, and whether every step comes to an end, whatever the values."""

    text: str
    ends: bool


def block_code(definition: FmuDefinition, careful: Collection[str],
               reserved: frozenset[str] = frozenset()) -> BlockCode:
    """The header BLOCK for a definition.

    Untranslatable, with file and line, if the block is not of the language. `careful` are
    packages whose code looks before it divides, `reserved` names of the C around it.
    """
    text = block_text(definition.new_block(), definition.continuous is not None, careful=careful, reserved=reserved,
                      settable=[v.place for v in definition.native_variables])
    functions = "\n".join(wrapper(definition, name, function) for name, function in text.methods.items())
    return BlockCode(filled(TEMPLATES / BLOCK, {
        "NAME": definition.name, "STRUCT": text.struct, "STRUCTS": text.structs, "FUNCTIONS": text.functions,
        "INITIAL": text.initial, "WRAPPERS": functions, "FAILURES": failures(text)}), text.ends)


def failures(text: BlockText) -> str:
    return "\n".join(f"    {c_string(site.text)}," for site in text.sites) or "    0"


def wrapper(definition: FmuDefinition, name: str, function: Function) -> str:
    """Return a function of the C layer that calls one of the block's; a failure in it becomes its status."""
    head, given = WRAPPED[name]
    failing = ", &failure" if function.fails else ""
    call = f"{function.name}(block{given}{failing})"
    kind = head.partition(" ")[0]
    lines = [f"static {head}", "{"]
    if function.fails:
        lines.append("    int64_t failure = 0;")
    if kind == "void":
        lines += [f"    {call};"]
    else:
        lines += [f"    {'const int64_t status' if kind == 'int64_t' else 'const bool jumps'} = {call};"]
        result = "status" if kind == "int64_t" else "jumps"
        if function.fails and kind == "int64_t":
            lines += ["    if (failure != 0) {", "        return FIRST_FAILURE + failure;", "    }"]
        if kind == "int64_t" and definition.finite and name in ("start", "step"):
            lines.append("    const Block *const law = block;")
            for status, place in definition.finite:
                lines += [f"    if (status == 0 && !isfinite(law->{c_path(place)})) {{", f"        return {status};",
                          "    }"]
        lines.append(f"    return {result};")
    return "\n".join([*lines, "}", ""])


def prefixed(code: str, prefix: str) -> str:
    """The text of a header BLOCK with a prefix for all names that it defines, for a program with several blocks."""
    structs = "|".join(STRUCT.findall(code))
    names = "|".join(name for found in DEFINED.findall(code) for name in found if name)
    code = re.sub(rf"\bstruct ({structs})\b", rf"struct {prefix}\1", code)
    code = re.sub(rf"(?<![.\w>])\b({names})\b", rf"{prefix}\1", code)
    return code.replace("BLOCK_H", f"{prefix}BLOCK_H".upper())


def model_table(definition: FmuDefinition, guid: str, timed: bool) -> str:
    """C source that defines MODEL; `timed` says whether the time is one of its variables.

    ValueError if a refusal names something that is no variable.
    """
    known = {v.name for v in definition.variables} | {"time", "step"}
    for text in definition.refusals.values():
        for name in re.findall(r"\{([\w.]+)\}", text):
            if name not in known:
                raise ValueError(f"{definition.name}: the refusal {text!r} names {name}, expected a variable")
    sampling = ""   # the layer's entry of the grid of samples
    if timed and definition.sampled:
        clock = len(definition.native_variables) + 1   # after the time
        sampling = (f"static const struct Sampling SAMPLING = {{"
                    f".clocked = {'true' if definition.clocked else 'false'}, .clock = {clock}}};\n\n")
    lengths = {array.elements[0]: str(len(array.elements)) for array in definition.arrays if timed}
    names = [*(v.name for v in definition.native_variables), "time"]
    sizes = wrapped(lengths.get(name, "1") for name in names) if lengths else ""
    return filled(TEMPLATES / TABLE, {
        "NAME": definition.name,
        "SIZES_TABLE": f"static const uint8_t SIZES[] = {{{sizes}}};\n\n" if sizes else "",
        "SIZES": "SIZES" if sizes else "NULL",
        "CONTINUOUS_TABLES": continuous_tables(definition),
        "CONTINUOUS": "&CONTINUOUS" if definition.continuous else "NULL",
        "VARIABLE_STEP": "true" if definition.variable_step else "false",
        "INTERVAL": f"AT({c_path(definition.sampling)})" if definition.sampling else "0",
        "SAMPLING_TABLE": sampling, "SAMPLING": "&SAMPLING" if sampling else "NULL",
        "NAME_TEXT": c_string(definition.name), "GUID": c_string(guid),
        "VARIABLES": "\n".join([*map(variable_row, definition.native_variables), *([TIME_ROW] if timed else [])]),
        "REFUSALS": "\n".join(f"    {{{c_literal(status)}, {c_string(text)}}},"
                              for status, text in sorted(definition.refusals.items()))})


def continuous_tables(definition: FmuDefinition) -> str:
    """C source of the layer's table of a continuous model; nothing for any other block."""
    model = definition.continuous
    if model is None:
        return ""
    reference = {v.name: number for number, v in enumerate(definition.native_variables)}
    nominal = {v.name: 1.0 if v.nominal is None else v.nominal for v in definition.native_variables}
    states = [state.variable for state in model.states]
    rates = [state.derivative for state in model.states]

    def references(names: Iterable[str]) -> str:
        return wrapped(str(reference[name]) for name in names)

    return filled(TEMPLATES / "continuous.c", {
        "STATES": references(states), "RATES": references(rates), "INDICATORS": references(model.indicators),
        "NOMINALS": wrapped(c_literal(nominal[name]) for name in states)})


def wrapped(cells: Iterable[str]) -> str:
    """Cells of a C array, on lines of their own."""
    return "\n    " + "\n    ".join(wrap(", ".join(cells), 110)) + "\n"


def variable_row(variable: Variable) -> str:
    cells = (c_string(variable.name), c_string(variable.unit), f"AT({c_path(variable.place)})",
             *("true" if each else "false" for each in (
                 variable.boolean, variable.variability == "discrete", variable.variability == "fixed")),
             variable.causality.upper(), c_literal(float(variable.low)), c_literal(float(variable.high)),
             c_string(variable.hinted))
    return f"    {{{', '.join(cells)}}},"
