"""Equations in TeX as MathML: a page shows them without a network, a script or a font of its own."""

import re
from functools import lru_cache

# In the HTML of a page: \(…\) within a line, \[…\] on a line of its own.
TEX = re.compile(r"\\\((.+?)\\\)|\\\[(.+?)\\\]", re.DOTALL)
PAIRS = ("{", "}"), (r"\\begin\b", r"\\end\b"), (r"\\left\b", r"\\right\b")


@lru_cache(maxsize=1024)
def mathml(tex: str, display: bool = False) -> str:
    """An equation within a line, or on a line of its own: there one for each part between \\qquad, to be wrapped."""
    # Reading its table of symbols takes a tenth of a second, which only who typesets something shall wait for.
    from latex2mathml.converter import convert

    if not display:
        return str(convert(tex))
    first, *others = tex.split(r"\qquad")
    parts = [first]
    for part in others:
        if all(len(re.findall(begun, parts[-1])) == len(re.findall(ended, parts[-1])) for begun, ended in PAIRS):
            parts.append(part)
        else:
            parts[-1] += rf"\qquad{part}"
    return "".join(convert(part, display="block") for part in parts)


def typeset(html: str) -> str:
    """HTML with its equations as MathML."""
    return TEX.sub(lambda match: mathml(match[1]) if match[1] else
                   f"<div>{mathml(match[2], display=True)}</div>", html)
