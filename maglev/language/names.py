"""Names of the Python as names of C."""

import re

from maglev.language.helpers import HELPERS

# Names that C has, or a header that is included here or around it: as names of the Python they get an underscore.
KEYWORDS = HELPERS.keys() | frozenset("""
    auto break case char const continue default do double else enum extern float for goto if inline int long
    register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while asm
    typeof bool true false NULL EOF INFINITY NAN I complex imaginary errno assert offsetof stdin stdout stderr
    CLOCKS_PER_SEC BUFSIZ unix linux near far double_t float_t fabs sqrt floor ceil trunc fmod remainder copysign
    isfinite isnan isinf signbit sin cos tan asin acos atan atan2 exp expm1 log log1p log2 log10 sinh cosh tanh erf
    erfc pow failure main block memcpy Block INITIAL FIRST_FAILURE FAILURES start_block step_block derive_block
    settle_block differentiate_block
    differentiate_start_block differentiate_measurement_block
""".split())   # noqa: SIM905 - so many as a list would take a page
MACROS = re.compile(r"_|(?:u?int\w*_t|size_t|ptrdiff_t|wchar_t|HUGE|FP|MATH|M|U?INT\d*|U?INTPTR|SIZE|PTRDIFF|WCHAR|"
                    r"WINT|SIG_ATOMIC|RAND|EXIT|DBL|FLT|LDBL|AT|BLOCK|BLOCKS|lanes|LANES|FMI\d?|SEEK)(?:_|$)|\w*__|\w+_t$")

def identifier(name: str) -> str:
    """A name of the Python as one of C; different names stay different."""
    name = "".join(letter if letter.isascii() else f"_u{ord(letter):x}_" for letter in name)
    base = name.rstrip("_")
    return f"{name}_" if base in KEYWORDS or MACROS.match(base) or name[:1] == "_" or name != base else name
