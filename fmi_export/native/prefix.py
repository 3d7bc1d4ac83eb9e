"""Names that the linker sees, made an FMU's own, so that several FMUs can be linked into one program."""

import re
from collections.abc import Iterable

from fmi_export.native.translation import TEMPLATES
from fmi_export.templates import filled

# Functions and objects that a header declares for other files; members of structures are indented.
EXTERNAL = re.compile(r"^(?!static\b|typedef\b)(?:extern )?\w[\w ]*[ *](\w+)(?:\([^;]*\))?;$", re.MULTILINE)


def prefix_header(name: str, headers: Iterable[str], functions: str) -> str:
    """C header that gives what the headers of an FMU declare for its other files the FMU's name as a prefix.

    `functions` is FMI's header of its functions, "fmi2Functions.h" or "fmi3Functions.h".
    """
    names = sorted({name for header in headers for name in EXTERNAL.findall(header)})
    return filled(TEMPLATES / "prefix.h", {
        "NAME": name, "HEADER": functions, "FMI": functions[:4].upper(),
        "NAMES": "\n".join(f"#define {external} {name}_{external}" for external in names)})
