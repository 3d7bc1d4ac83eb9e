"""What code for a graphics processor computes with: whether each operation rounds once, to the nearest."""

import re
from collections import Counter

# Rounded once, to the nearest; comparisons, signs, choices; conversions from and to whole numbers, and numbers without
# their fraction.
EXACT = {*(f"{each}.rn.f64" for each in ("add", "sub", "mul", "div", "rcp", "sqrt")), "neg.f64", "abs.f64", "min.f64",
         "max.f64", "setp.f64", "selp.f64", "cvt.rn.f64.s64", "cvt.rn.f64.u64", "cvt.rn.f64.s32", "cvt.rn.f64.u32",
         "cvt.rzi.s64.f64", "cvt.rzi.s32.f64", "cvt.rzi.f64.f64"}


def of_numbers(code: str) -> Counter[str]:
    """How often each instruction that computes with floating-point numbers, or compares them, is in it."""
    found = re.findall(r"^\s+(?:@\S+\s+)?([a-z]\w*\.\S*\bf(?:16|32|64)\b\S*)", code, re.MULTILINE)
    return Counter(re.sub(r"^setp\.\w+\.", "setp.", each) for each in found
                   if not each.startswith(("ld.", "st.", "mov.")))


def require_exact(made: str, *functions: str) -> None:
    """Nothing is contracted, approximate, flushed to zero or in single precision; what is called takes a number."""
    found = of_numbers(made)
    assert found.keys() <= EXACT, found.keys() - EXACT
    assert min(found[f"{each}.rn.f64"] for each in ("add", "sub", "mul", "div", "sqrt")) > 0
    assert all(f".visible .entry {function}(" in made for function in functions) and ".extern" not in made
    called = re.findall(r"^\s+call(?:\.uni)? \(\w+\), (\w+), \(\w+\);", made, re.MULTILINE)
    assert len(called) == len(re.findall(r"^\s+call\b", made, re.MULTILINE)), "a call with blocks puts them into memory"
    assert all(re.search(rf"\(\.param \.b64 \w+\) {name}\s*\(\s*\.param \.b64 \w+\s*\)", made) for name in called)
