"""C of numbers that differ between lanes: vectors of LANES numbers, masks, and functions that replace operators.

A mask is a vector of whole numbers, -1 in the lanes that are meant and 0 in others. Compilers with clang's vectors take
these, which select by `?:`; others take GCC's.
"""

# The beginning of a program of lanes; `LANES` is defined before it.
TYPES = """\
#if defined __clang__
typedef double lanes_float __attribute__((ext_vector_type(LANES)));
typedef int64_t lanes_int __attribute__((ext_vector_type(LANES)));
#else
typedef double lanes_float __attribute__((vector_size(8 * LANES)));
typedef int64_t lanes_int __attribute__((vector_size(8 * LANES)));
#endif
#define LANES_ALL (~(lanes_int){0})
#define LANES_LOOP for (int _lane = 0; _lane < LANES; ++_lane)

static inline bool lanes_any(lanes_int mask)
{
#if defined __clang__
    return __builtin_reduce_or(mask) != 0;
#else
    int64_t any = 0;
    LANES_LOOP any |= mask[_lane];
    return any != 0;
#endif
}

static inline lanes_float lanes_of_float(double x)
{
    lanes_float result;
    LANES_LOOP result[_lane] = x;
    return result;
}

static inline void lanes_put(double *to, lanes_float x) { __builtin_memcpy(to, &x, sizeof x); }

static inline lanes_int lanes_of_int(int64_t k)
{
    lanes_int result;
    LANES_LOOP result[_lane] = k;
    return result;
}

static inline lanes_int lanes_of_bool(bool truth) { return lanes_of_int(-(int64_t)truth); }

static inline lanes_int lanes_only(int lane)
{
    lanes_int result = {0};
    result[lane] = -1;
    return result;
}

static inline lanes_float lanes_select(lanes_int mask, lanes_float yes, lanes_float no)
{
#if defined __clang__
    return mask ? yes : no;
#else
    return (lanes_float)(((lanes_int)yes & mask) | ((lanes_int)no & ~mask));
#endif
}

static inline lanes_int lanes_select_int(lanes_int mask, lanes_int yes, lanes_int no)
{
#if defined __clang__
    return mask ? yes : no;
#else
    return (yes & mask) | (no & ~mask);
#endif
}

static inline lanes_float lanes_fabs(lanes_float x)
{
    return (lanes_float)((lanes_int)x & lanes_of_int(INT64_MAX));
}

static inline lanes_float lanes_copysign(lanes_float x, lanes_float sign)
{
    return (lanes_float)(((lanes_int)x & lanes_of_int(INT64_MAX)) | ((lanes_int)sign & lanes_of_int(INT64_MIN)));
}

static inline lanes_int lanes_isnan(lanes_float x) { return x != x; }
static inline lanes_int lanes_isfinite(lanes_float x) { return lanes_fabs(x) < lanes_of_float(INFINITY); }
static inline lanes_int lanes_isinf(lanes_float x) { return lanes_fabs(x) == lanes_of_float(INFINITY); }

static inline void lanes_note(lanes_int *failure, lanes_int failed, int64_t place)
{
    if (failure && lanes_any(failed)) {
        *failure = lanes_select_int(failed & (*failure == 0), lanes_of_int(place), *failure);
    }
}
"""

# Functions of one number that a processor has for vectors, by clang's names.
BUILT_IN = ("sqrt", "floor", "ceil", "trunc")

# Functions of all lanes at once, with the names of the helpers for one lane; some leave rare cases to those.
TOGETHER = {
    "quotient": """\
static inline lanes_float lanes_quotient(lanes_float a, lanes_float b, lanes_int live, lanes_int *failure,
                                         int64_t place)
{
    lanes_note(failure, live & (b == lanes_of_float(0.0)), place);
    return a / b;
}
""",
    "computed": """\
static inline lanes_float lanes_computed(lanes_float result, lanes_float a, lanes_float b, lanes_int live,
                                         lanes_int *failure, int64_t place)
{
    lanes_note(failure, live & ((lanes_isnan(result) & ~lanes_isnan(a) & ~lanes_isnan(b))
                                | (lanes_isinf(result) & lanes_isfinite(a) & lanes_isfinite(b))), place);
    return result;
}
""",
    "whole": """\
static inline lanes_int lanes_whole(lanes_float x, lanes_int live, lanes_int *failure, int64_t place)
{
    const lanes_int small = lanes_fabs(x) < lanes_of_float(2251799813685248.0);   /* 2^51 */
    const lanes_float shift = lanes_of_float(6755399441055744.0);
    if (lanes_any(live & ~small)) {
        return lanes_whole_each(x, live, failure, place);
    }
    return (lanes_int)(lanes_trunc(lanes_select(small, x, lanes_of_float(0.0))) + shift) - (lanes_int)shift;
}
""",
    "sum": """\
static inline lanes_int lanes_sum(lanes_int a, lanes_int b, lanes_int live, lanes_int *failure, int64_t place)
{
    const lanes_int result = (lanes_int)((lanes_bits)a + (lanes_bits)b);
    if (lanes_any(live & (((a ^ result) & (b ^ result)) < 0))) {
        return lanes_sum_each(a, b, live, failure, place);
    }
    return result;
}
""",
    "difference": """\
static inline lanes_int lanes_difference(lanes_int a, lanes_int b, lanes_int live, lanes_int *failure, int64_t place)
{
    const lanes_int result = (lanes_int)((lanes_bits)a - (lanes_bits)b);
    if (lanes_any(live & (((a ^ b) & (a ^ result)) < 0))) {
        return lanes_difference_each(a, b, live, failure, place);
    }
    return result;
}
""",
}
BITS = """\
#if defined __clang__
typedef uint64_t lanes_bits __attribute__((ext_vector_type(LANES)));
#else
typedef uint64_t lanes_bits __attribute__((vector_size(8 * LANES)));
#endif
"""
ALONE = ("quotient", "computed")   # of `TOGETHER`: need no helper of one lane

FLOATS, INTS = "double", "int64_t"
# Results and operands of helpers that note in `failure`, and of those that cannot fail.
FAILING = {"quotient": (FLOATS, FLOATS, FLOATS), "computed": (FLOATS, FLOATS, FLOATS, FLOATS), "whole": (INTS, FLOATS),
           "element": (INTS, INTS, INTS), "sum": (INTS, INTS, INTS), "difference": (INTS, INTS, INTS),
           "product": (INTS, INTS, INTS), "floor_quotient": (INTS, INTS, INTS), "modulo": (INTS, INTS, INTS),
           "shifted_left": (INTS, INTS, INTS), "shifted_right": (INTS, INTS, INTS), "absolute": (INTS, INTS),
           "quotient_of_wholes": (FLOATS, INTS, INTS)}
SURE = {"order_of": (FLOATS, INTS, FLOATS)}
LANES_OF = {FLOATS: "lanes_float", INTS: "lanes_int"}


def built_in(name: str) -> str:
    """A function of one number, which processors have."""
    return f"""\
static inline lanes_float lanes_{name}(lanes_float x)
{{
#if defined __clang__
    return __builtin_elementwise_{name}(x);
#else
    LANES_LOOP x[_lane] = {name}(x[_lane]);
    return x;
#endif
}}
"""


def each(name: str, kinds: tuple[str, ...], suffix: str = "") -> str:
    """A function of numbers that is computed lane by lane."""
    result, *operands = kinds
    given = ", ".join(f"{LANES_OF[kind]} {letter}" for kind, letter in zip(operands, "abc", strict=False))
    one = ", ".join(f"{letter}[_lane]" for letter, _ in zip("abc", operands, strict=False))
    return f"""\
static inline {LANES_OF[result]} lanes_{name}{suffix}({given})
{{
    {LANES_OF[result]} result = {{0}};
    LANES_LOOP result[_lane] = {name}({one});
    return result;
}}
"""


def failing_each(name: str, suffix: str) -> str:
    """A helper, lane by lane where they are live."""
    result, *operands = FAILING[name]
    given = ", ".join(f"{LANES_OF[kind]} {letter}" for kind, letter in zip(operands, "abc", strict=False))
    one = ", ".join(f"{letter}[_lane]" for letter, _ in zip("abc", operands, strict=False))
    return f"""\
static inline {LANES_OF[result]} lanes_{name}{suffix}({given}, lanes_int live, lanes_int *failure, int64_t place)
{{
    {LANES_OF[result]} result = {{0}};
    LANES_LOOP {{
        if (live[_lane]) {{
            int64_t failed = 0;
            result[_lane] = {name}({one}, &failed, place);
            if (failed != 0 && failure && (*failure)[_lane] == 0) {{
                (*failure)[_lane] = failed;
            }}
        }}
    }}
    return result;
}}
"""


def failing_together(name: str) -> str:
    """A helper for values that all lanes have in common; it fails in the live lanes."""
    result, *operands = FAILING[name]
    given = ", ".join(f"{kind} {letter}" for kind, letter in zip(operands, "abc", strict=False))
    values = ", ".join(letter for letter, _ in zip("abc", operands, strict=False))
    return f"""\
static inline {result} lanes_common_{name}({given}, lanes_int live, lanes_int *failure, int64_t place)
{{
    int64_t failed = 0;
    const {result} result = {name}({values}, &failed, place);
    if (failed != 0) {{
        lanes_note(failure, live, failed);
    }}
    return result;
}}
"""


def lane_helper(name: str) -> str:
    """Text of a function of lanes, without `lanes_` in its name: a helper, or a function of <math.h>."""
    if name in BUILT_IN:
        return built_in(name)
    if name.startswith("common_"):
        return failing_together(name.removeprefix("common_"))
    if name in TOGETHER:
        return ("" if name in ALONE else failing_each(name, "_each")) + TOGETHER[name]
    if name in FAILING:
        return failing_each(name, "")
    return each(name, SURE.get(name, (FLOATS, FLOATS, FLOATS)[:2 if name not in TWO else 3]))


TWO = ("fmod", "remainder", "atan2", "pow")
