"""Names that no axis and no motor of a description can have."""

import re
from functools import cache
from keyword import kwlist
from pathlib import Path

TEMPLATES = Path(__file__).with_name("templates")
MARKED = re.compile(r"\{[{%].*?[%}]\}", re.DOTALL)
KEYWORDS_OF_C = {
    "auto", "case", "char", "const", "default", "do", "double", "enum", "extern", "float", "goto", "inline", "int",
    "long", "register", "restrict", "short", "signed", "sizeof", "static", "struct", "switch", "typedef", "union",
    "unsigned", "void", "volatile"}
HELD = "level"   # the tilt that guides hold, where there is one horizontal axis
# Words with which variables of FMUs begin, next to axes and motors.
VARIABLES = {
    "at_stop", "attraction_modulation", "bus_voltage", "encoder", "epsilon", "gamma", "geometry", "height",
    "magnet_rise", "payload", "guide_seed", "yaw_moment"}
OWN = re.compile(r"self\.(\w+)|^ *([\w, ]+) = |\bdef (\w+)|\bfor (\w+) in|^from \S+ import (.+)$", re.MULTILINE)


@cache
def own_names() -> frozenset[str]:
    """Names that blocks have of their own: no axis and no motor can be called so."""
    taken = {*kwlist, *KEYWORDS_OF_C, *VARIABLES, "self", "t", "dt", "law", HELD,
             "time"}   # which is a column of recordings
    for path in TEMPLATES.rglob("*.j2"):
        if path.name.endswith((".html.j2", ".toml.j2")) or path.parent.name in ("repository", "written"):
            continue
        code = MARKED.sub("Ø", path.read_text(encoding="utf-8"))   # a letter that no name has
        taken.update(name for group in OWN.findall(code) for name in re.findall(r"\w+", "".join(group)))
    return frozenset(taken)
