"""Names that the linker sees, made an FMU's own, so that several FMUs can be linked into one program."""

import re
from collections.abc import Iterable

# Functions and objects that a header declares for other files; members of structures are indented.
EXTERNAL = re.compile(r"^(?!static\b|typedef\b)(?:extern )?\w[\w ]*[ *](\w+)(?:\([^;]*\))?;$", re.MULTILINE)

HEADER = """\
/* Names of {name} that the linker sees, so that it can be linked into one program with other FMUs (FMI 2.0.5, 2.1.1).
 *
 * The functions of FMI get the prefix from {header}. A shared library exports them without: its compiler is to
 * define {fmi}_OVERRIDE_FUNCTION_PREFIX. */

#ifndef PREFIX_H
#define PREFIX_H

#ifndef {fmi}_OVERRIDE_FUNCTION_PREFIX
#define {fmi}_FUNCTION_PREFIX {name}_
#endif

{names}

#endif
"""


def prefix_header(name: str, headers: Iterable[str], functions: str) -> str:
    """C header that gives what the headers of an FMU declare for its other files the FMU's name as a prefix.

    `functions` is FMI's header of its functions, "fmi2Functions.h" or "fmi3Functions.h".
    """
    names = sorted({name for header in headers for name in EXTERNAL.findall(header)})
    return HEADER.format(name=name, header=functions, fmi=functions[:4].upper(),
                         names="\n".join(f"#define {external} {name}_{external}" for external in names))
