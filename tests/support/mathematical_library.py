"""What a Python text takes of a mathematical library: the last bits of another machine are others."""

import ast
import math
from collections.abc import Iterator

import numpy as np

# Whose value the standard says to the last bit, or which compute nothing.
EXACT = {"sqrt", "fabs", "copysign", "floor", "ceil", "trunc", "fmod", "remainder", "frexp", "ldexp", "modf",
         "nextafter", "ulp", "isfinite", "isinf", "isnan", "isclose", "fsum", "prod", "gcd", "lcm", "comb", "perm",
         "factorial", "isqrt", "degrees", "radians", "pi", "e", "tau", "inf", "nan"}
OF_MATH = {name for name in dir(math) if not name.startswith("_")} - EXACT

# Of NumPy the functions that compute element by element, except for those of one operation, and what is made of others.
OF_ONE_OPERATION = EXACT | {
    "add", "subtract", "multiply", "divide", "true_divide", "negative", "positive", "abs", "absolute", "square",
    "reciprocal", "conj", "conjugate", "rint", "sign", "signbit", "spacing", "minimum", "maximum", "fmin", "fmax",
    "clip", "equal", "not_equal", "less", "less_equal", "greater", "greater_equal", "isnat", "heaviside", "mod",
    "floor_divide", "divmod", "deg2rad", "rad2deg", "logical_and", "logical_or", "logical_not", "logical_xor",
    "bitwise_and", "bitwise_or", "bitwise_xor", "bitwise_not", "bitwise_invert", "bitwise_count", "bitwise_left_shift",
    "bitwise_right_shift", "invert", "left_shift", "right_shift", "matmul", "matvec", "vecdot", "vecmat"}
OF_NUMPY = {name for name in dir(np) if isinstance(getattr(np, name), np.ufunc)} - OF_ONE_OPERATION | {
    "fft", "linalg", "polynomial", "polyfit", "angle", "unwrap", "sinc", "interp", "geomspace", "logspace"}
LIBRARIES = {"math": OF_MATH, "numpy": OF_NUMPY}
WHOLE = {"cmath", "scipy", "statistics"}   # of which nothing is known
USUAL = {"math": None, "numpy": "np"}      # under which names a module may have them
BY_NAME = {usual or library: LIBRARIES[library] for library, usual in USUAL.items()}


def inexact(text: str) -> list[str]:
    """Such functions in the text of a module, each as its line and its name."""
    return [f"{node.lineno}: {name}" for node in ast.walk(ast.parse(text))
            if isinstance(node, (ast.expr, ast.stmt)) for name in taken(node)]


def taken(node: ast.expr | ast.stmt) -> Iterator[str]:
    """Those that one node names; a library under another name than its usual one is refused whole."""
    if isinstance(node, ast.ImportFrom) and node.module and not node.level:
        package, *parts = node.module.split(".")
        for name in (*parts, *(alias.name for alias in node.names)):
            if package in WHOLE or name in LIBRARIES.get(package, ()) or (name == "*" and package in LIBRARIES):
                yield f"{node.module}: {name}"
    elif isinstance(node, ast.Import):
        for alias in node.names:
            package, *parts = alias.name.split(".")
            known = LIBRARIES.get(package, set())
            if package in WHOLE or known & {*parts} or (known and not parts and alias.asname != USUAL[package]):
                yield alias.name
    elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        if node.attr in BY_NAME.get(node.value.id, ()):
            yield f"{node.value.id}.{node.attr}"
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "pow":
        yield "pow"
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and not of_whole(node):
        yield ast.unparse(node)


def of_whole(power: ast.BinOp) -> bool:
    """Whether a power is a product, or of two numbers that are written down."""
    return (isinstance(power.right, ast.Constant) and isinstance(power.right.value, int)) or not any(
        isinstance(node, (ast.Name, ast.Attribute, ast.Call, ast.Subscript)) for node in ast.walk(power))
