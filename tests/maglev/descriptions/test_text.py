"""What templates do to text."""

import ast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from maglev.descriptions.writer import (
    LONGEST,
    each,
    factor,
    fitted,
    sum_text,
)

NAMES = st.lists(st.from_regex("[a-z]{1,12}", fullmatch=True), min_size=1, max_size=30)
STATEMENTS = {"held = ({})": " or ", "self.plant.held = ({})": " and ", "call({})": ", ", "table = {{'a': {}}}": " == ",
              "if not ({}):\n            pass": " or ", "torque = (height * thrust + {})": " - "}


@pytest.mark.parametrize(("terms", "sums"), [(["a"], "f(a)"), (["a", "b"], "(f(a) + f(b))")])
def test_terms(terms: list[str], sums: str) -> None:
    assert sum_text(terms, "f({0})") == sums
    assert each(terms, "{0}.i_d", " + ") == " + ".join(f"{term}.i_d" for term in terms)
    assert factor(1.0) + sum_text(terms) == sum_text(terms)
    assert factor(2.0) + "a" == "2.0 * a"


@given(names=NAMES, statement=st.sampled_from(sorted(STATEMENTS)))
def test_lines_that_are_too_long_are_broken_and_say_the_same(names: list[str], statement: str) -> None:
    between = STATEMENTS[statement]
    text = "def f():\n        " + statement.format(between.join(f"{name}_.x(y, z)" for name in names)) + "\n"
    shown = fitted(text)
    assert ast.dump(ast.parse(shown)) == ast.dump(ast.parse(text))
    assert all(len(line) <= LONGEST for line in shown.splitlines())
    if all(len(line) <= LONGEST for line in text.splitlines()):
        assert shown == text


def test_a_comment_stays_behind_its_line() -> None:
    long = " or ".join(["an_attribute.of_something"] * 5)
    assert fitted(f"held = ({long})   # by any, or none\n").endswith("of_something)   # by any, or none\n")


def test_a_line_that_is_not_in_one_bracket_is_left_as_it_is() -> None:
    for text in (" + ".join(["f(x)"] * 30), " + ".join(["x"] * 100)):
        assert fitted(text) == text


def test_documentation_is_left_as_it_is() -> None:
    words = "word, " * 40
    text = f'def f():\n    """A {words}\n\n    (and {words}\n    """\n'
    assert fitted(text) == text
