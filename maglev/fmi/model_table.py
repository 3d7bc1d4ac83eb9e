"""The table of an FMU's variables as C, for its FMI layer."""

import re
from collections.abc import Iterable
from textwrap import wrap

from maglev.fmi.block_code import TEMPLATES, c_path
from maglev.fmi.definition import FmuDefinition, Variable
from maglev.fmi.escapes import c_string
from maglev.fmi.templates import filled
from maglev.language.c_text import c_literal

SOURCE = TEMPLATES / "model.c"

# The independent variable of FMI 3.0, after the others: where the next communication step starts.
TIME = """\
    {"time", "s", offsetof(struct RunState, progress.next_time), false, false, false, INDEPENDENT, -INFINITY,
     INFINITY, ""},"""


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
    return filled(SOURCE, {
        "NAME": definition.name,
        "SIZES_TABLE": f"static const uint8_t SIZES[] = {{{sizes}}};\n\n" if sizes else "",
        "SIZES": "SIZES" if sizes else "NULL",
        "CONTINUOUS_TABLES": continuous_tables(definition),
        "CONTINUOUS": "&CONTINUOUS" if definition.continuous else "NULL",
        "VARIABLE_STEP": "true" if definition.variable_step else "false",
        "INTERVAL": f"AT({c_path(definition.sampling)})" if definition.sampling else "0",
        "SAMPLING_TABLE": sampling, "SAMPLING": "&SAMPLING" if sampling else "NULL",
        "NAME_TEXT": c_string(definition.name), "GUID": c_string(guid),
        "VARIABLES": "\n".join([*map(variable_row, definition.native_variables), *([TIME] if timed else [])]),
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
