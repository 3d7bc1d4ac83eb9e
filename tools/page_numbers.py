"""Hold numbers in the pages to the runs that they are of: `python tools/page_numbers.py`, a part of `make docs`.

Flies the runs that page_numbers.toml names, and exits with 1 where a page has other numbers.
"""

import re
import sys
import tomllib
from functools import cache
from pathlib import Path
from statistics import fmean

import maglev
from maglev.files.units import to_unit

ROOT = Path(__file__).parents[1]
LIST = Path(__file__).with_suffix(".toml")
VALUE = re.compile(r"(?P<run>\S+?)(?P<jacobi> jacobi)?: (?P<mean>mean of steps, )?(?P<quantity>.+?)"
                   r"(?: of (?P<of>\w+))? in (?P<unit>\S+)")


def main() -> int:
    wrong = 0
    for page, rows in tomllib.loads(LIST.read_text(encoding="utf-8")).items():
        text = " ".join((ROOT / "docs" / page).read_text(encoding="utf-8").split())
        for template, *specifications in rows:
            expected = template.format(*(run_number(specification) for specification in specifications))
            if expected not in text:
                wrong += 1
                print(f"docs/{page}: expected {expected!r} by {', '.join(specifications)}")
    return 1 if wrong else 0


def run_number(specification: str) -> float:
    """Return the metric of a run, in the unit: the largest of all steps and events, or their mean."""
    match = VALUE.fullmatch(specification)
    if match is None:
        sys.exit(f"{LIST.name}: {specification!r}: expected 'RUN: QUANTITY of AXIS in UNIT'")
    values = [measure.value for measure in run_of(match["run"], bool(match["jacobi"])).measures
              if (measure.quantity, measure.of) == (match["quantity"], match["of"] or "")]
    if not values:
        sys.exit(f"{LIST.name}: {specification!r}: the run has no such quantity")
    return to_unit(fmean(values) if match["mean"] else max(values), match["unit"])


@cache
def run_of(name: str, jacobi: bool) -> maglev.Run:
    return maglev.run(name, order="jacobi" if jacobi else "sequential")


if __name__ == "__main__":
    sys.exit(main())
