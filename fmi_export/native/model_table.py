"""The table of an FMU's variables as C, for its FMI layer."""

import re
from math import inf

from fmi_export.definition import FmuDefinition, Variable
from fmi_export.native.translation import literal

SOURCE = """\
/* {name}: the block, its variables and its refusals. Generated from the table that the model description is made of. */

#include "instance.h"
#include "{header}"

static void construct(void *block)
{{
    {block}__init__({arguments});
}}

static int64_t start(void *block)
{{
    return {block}__start(block);
}}

static int64_t step(void *block, double time, double size)
{{
    return {block}__step(block, time, size);
}}

#define AT(path) (offsetof(struct RunState, block) + offsetof(struct {block}, path))

static const struct Variable VARIABLES[] = {{
{variables}
}};

static const struct Refusal REFUSALS[] = {{
{refusals}
}};

const struct Model MODEL = {{
    .name = {name_text},
    .guid = {guid},
    .block_size = sizeof(struct {block}),
    .construct = construct,
    .start = start,
    .step = step,
    .variables = VARIABLES,
    .variable_count = sizeof VARIABLES / sizeof *VARIABLES,
    .refusals = REFUSALS,
    .refusal_count = sizeof REFUSALS / sizeof *REFUSALS,
}};
"""


# The independent variable of FMI 3.0, after the others: where the next communication step starts.
TIME = """\
    {"time", "s", offsetof(struct RunState, progress.next_time), false, false, INDEPENDENT, -INFINITY, INFINITY, ""},"""


def model_table(definition: FmuDefinition, guid: str, timed: bool) -> str:
    """C source that defines MODEL; `timed` says whether the time is one of its variables.

    Raises
    ------
    ValueError
        If a refusal names something that is no variable.
    """
    block = definition.block
    arguments = ", ".join(["block", *(literal(argument) for argument in definition.arguments)])
    known = {v.name for v in definition.variables} | {"time", "step"}
    for text in definition.refusals.values():
        for name in re.findall(r"\{([\w.]+)\}", text):
            if name not in known:
                raise ValueError(f"{definition.name}: the refusal {text!r} names {name}, expected a variable")
    return SOURCE.format(
        name=definition.name, header=f"{block.__module__.rpartition('.')[2]}.h", block=block.__name__,
        arguments=arguments, name_text=text_literal(definition.name), guid=text_literal(guid),
        variables="\n".join([*(variable_row(v) for v in definition.variables), *([TIME] if timed else [])]),
        refusals="\n".join(f"    {{{literal(status)}, {text_literal(text)}}},"
                           for status, text in sorted(definition.refusals.items())))


def variable_row(variable: Variable) -> str:
    """One row of the table."""
    low = -inf if variable.minimum is None else float(variable.minimum)
    high = inf if variable.maximum is None else float(variable.maximum)
    cells = (text_literal(variable.name), text_literal(variable.unit), f"AT({variable.place})",
             "true" if variable.boolean else "false", "true" if variable.variability == "fixed" else "false",
             variable.causality.upper(), literal(low), literal(high), text_literal(variable.hinted))
    return f"    {{{', '.join(cells)}}},"


def text_literal(text: str) -> str:
    """C string literal, in UTF-8 and without anything that its source's encoding could change."""
    return '"' + "".join(character if " " <= character <= "~" and character not in '"\\?' else escaped(character)
                         for character in text) + '"'


def escaped(character: str) -> str:
    """Octal escapes of a character: unlike hexadecimal ones they have an end."""
    return "".join(f"\\{byte:03o}" for byte in character.encode("utf-8"))
