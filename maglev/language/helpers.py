"""C functions that a translated block calls for operations of Python that C has no operator for."""

from maglev.language.program import FLOAT, INT

# Operations for which C has no operator, by the operation and the type of its operands; each notes in `failure` where
# it failed. The first failure of a step is kept.
HELPERS = {
    "note_failure": """\
static void note_failure(int64_t *failure, int64_t place)
{
    if (*failure == 0) {
        *failure = place;
    }
}
""",
    "quotient": """\
static inline double quotient(double a, double b, int64_t *failure, int64_t place)
{
    if (b == 0.0) {
        note_failure(failure, place);
    }
    return a / b;
}
""",
    "computed": """\
static inline double computed(double result, double a, double b, int64_t *failure, int64_t place)
{
    if (isnan(result) ? !isnan(a) && !isnan(b) : isinf(result) && isfinite(a) && isfinite(b)) {
        note_failure(failure, place);
    }
    return result;
}
""",
    "whole": """\
static inline int64_t whole(double x, int64_t *failure, int64_t place)
{
    if (x >= -9223372036854775808.0 && x < 9223372036854775808.0) {
        return (int64_t)x;
    }
    note_failure(failure, place);
    return 0;
}
""",
    "element": """\
static inline int64_t element(int64_t k, int64_t length, int64_t *failure, int64_t place)
{
    if (k >= 0 && k < length) {
        return k;
    }
    if (k < 0 && k >= -length) {
        return k + length;
    }
    note_failure(failure, place);
    return 0;
}
""",
    "sum": """\
static inline int64_t sum(int64_t a, int64_t b, int64_t *failure, int64_t place)
{
    if (b > 0 ? a > INT64_MAX - b : a < INT64_MIN - b) {
        note_failure(failure, place);
        return 0;
    }
    return a + b;
}
""",
    "difference": """\
static inline int64_t difference(int64_t a, int64_t b, int64_t *failure, int64_t place)
{
    if (b < 0 ? a > INT64_MAX + b : a < INT64_MIN + b) {
        note_failure(failure, place);
        return 0;
    }
    return a - b;
}
""",
    "product": """\
static inline int64_t product(int64_t a, int64_t b, int64_t *failure, int64_t place)
{
    const int64_t half = INT64_C(0x7fffffff);
    if (a < -half || a > half || b < -half || b > half) {
        if (a > 0 ? (b > 0 ? a > INT64_MAX / b : b < INT64_MIN / a)
                  : (b > 0 ? a < INT64_MIN / b : a != 0 && b < INT64_MAX / a)) {
            note_failure(failure, place);
            return 0;
        }
    }
    return a * b;
}
""",
    "floor_quotient": """\
static inline int64_t floor_quotient(int64_t a, int64_t b, int64_t *failure, int64_t place)
{
    if (b == 0 || (b == -1 && a == INT64_MIN)) {
        note_failure(failure, b == 0 ? place : place + 1);
        return 0;
    }
    return a / b - (a % b != 0 && (a < 0) != (b < 0) ? 1 : 0);
}
""",
    "modulo": """\
static inline int64_t modulo(int64_t a, int64_t b, int64_t *failure, int64_t place)
{
    if (b == 0) {
        note_failure(failure, place);
        return 0;
    }
    if (b == -1) {
        return 0;
    }
    return a % b + (a % b != 0 && (a < 0) != (b < 0) ? b : 0);
}
""",
    "shifted_left": """\
static inline int64_t shifted_left(int64_t a, int64_t by, int64_t *failure, int64_t place)
{
    const int64_t shifted = by >= 0 && by < 64 ? (int64_t)((uint64_t)a << by) : 0;
    if (by < 0 || (a != 0 && (by > 63 || shifted >> by != a))) {
        note_failure(failure, by < 0 ? place : place + 1);
        return 0;
    }
    return shifted;
}
""",
    "shifted_right": """\
static inline int64_t shifted_right(int64_t a, int64_t by, int64_t *failure, int64_t place)
{
    if (by < 0) {
        note_failure(failure, place);
        return 0;
    }
    return a >> (by > 63 ? 63 : by);
}
""",
    "absolute": """\
static inline int64_t absolute(int64_t a, int64_t *failure, int64_t place)
{
    if (a == INT64_MIN) {
        note_failure(failure, place);
        return 0;
    }
    return a < 0 ? -a : a;
}
""",
    "quotient_of_wholes": """\
static double quotient_of_wholes(int64_t a, int64_t b, int64_t *failure, int64_t place)
{
    const int64_t exact = INT64_C(9007199254740992);
    uint64_t divisor, rest, digits;
    double result;
    int shift = 0;
    if (b == 0) {
        note_failure(failure, place);
        return 0.0;
    }
    if (a >= -exact && a <= exact && b >= -exact && b <= exact) {
        return (double)a / (double)b;
    }
    divisor = b < 0 ? 0 - (uint64_t)b : (uint64_t)b;
    rest = a < 0 ? 0 - (uint64_t)a : (uint64_t)a;
    digits = rest / divisor;
    rest %= divisor;
    while (digits < (uint64_t)1 << 55 && (digits | rest) != 0) {   /* more digits than a double has */
        rest <<= 1;
        digits = digits << 1 | (rest >= divisor ? 1u : 0u);
        rest -= rest >= divisor ? divisor : 0;
        ++shift;
    }
    result = (double)(digits | (rest != 0 ? 1u : 0u));
    for (; shift > 0; --shift) {
        result *= 0.5;
    }
    return (a < 0) != (b < 0) ? -result : result;
}
""",
    "order_of": """\
static inline double order_of(int64_t a, double b)
{
    int64_t part;
    if (!(b >= -9223372036854775808.0 && b < 9223372036854775808.0)) {
        return isnan(b) ? b : b > 0.0 ? -1.0 : 1.0;
    }
    part = (int64_t)b;
    if (a != part) {
        return a < part ? -1.0 : 1.0;
    }
    return (double)part < b ? -1.0 : (double)part > b ? 1.0 : 0.0;
}
""",
    "next_turn": """\
static inline int64_t next_turn(int64_t k, int64_t step, int64_t stop)
{
    if (step > 0 ? k > INT64_MAX - step : k < INT64_MIN - step) {
        return stop;
    }
    return k + step;
}
""",
    "smaller": "static inline double smaller(double a, double b)\n{\n    return b < a ? b : a;\n}\n",
    "larger": "static inline double larger(double a, double b)\n{\n    return b > a ? b : a;\n}\n",
    "smaller_whole": "static inline int64_t smaller_whole(int64_t a, int64_t b)\n{\n    return b < a ? b : a;\n}\n",
    "larger_whole": "static inline int64_t larger_whole(int64_t a, int64_t b)\n{\n    return b > a ? b : a;\n}\n",
}
CHECKED = {"+": "sum", "-": "difference", "*": "product", "//": "floor_quotient", "%": "modulo", "<<": "shifted_left",
           ">>": "shifted_right"}
EXTREMES = {("min", FLOAT): "smaller", ("max", FLOAT): "larger", ("min", INT): "smaller_whole",
            ("max", INT): "larger_whole"}
