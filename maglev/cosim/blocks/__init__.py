"""FMUs whose blocks are compiled into one loop, in place of calls of them; what is around the blocks lies here as C."""

from pathlib import Path
from string import Template

HERE = Path(__file__).parent


def filled(file: Path, **what: object) -> str:
    """Text of a file of C, with what stands in place of its `$names`."""
    return Template(file.read_text(encoding="utf-8")).substitute(what)
