"""The comparison of laws at equal margins: poles, the search for a factor, and that the page has its rows."""

import numpy as np
import pytest

from maglev.linear.design import regulator_polynomial
from studies.equal_margin import DOCS, HEADS, LAWS, OMEGA0, POLES, factors, gains


def test_gains_place_the_poles_times_a_factor() -> None:
    placed = gains(2.0, 3.0)
    for axis, factor in (("y", 2.0), ("x", 3.0), ("z", 3.0)):
        polynomial = regulator_polynomial([placed[f"{axis}.k{k}"] for k in range(1, 6)], OMEGA0)
        # Of polynomials, for clustered roots are ill-conditioned.
        assert polynomial == pytest.approx(np.poly(factor * np.array(POLES)), rel=1e-9)


def test_factors_meet_the_margins_of_each_axis() -> None:
    def margins(y: float, x: float) -> dict[str, tuple[float, float]]:
        return {"y": (0.03 / y**1.2, 50.0), "x": (0.02 / (1.0 + x), 50.0)}

    assert factors(margins, {"y": 5e-3, "x": 4e-3}) == pytest.approx([6.0 ** (1 / 1.2), 4.0], rel=0.02)


def test_the_page_has_every_law_and_the_gains_of_the_thesis() -> None:
    page = DOCS.read_text(encoding="utf-8")
    rows = page[page.index("<!-- margins:"):page.index("<!-- end of margins -->")].splitlines()
    table = [row for row in rows if row.startswith("|")]
    assert table[0] == f"| {' | '.join(HEADS)} |"
    assert [row.split(" | ")[0] for row in table[2:]] == [
        "| regulator, thesis's gains", *(f"| {law}" for law in LAWS), "| ADRC"]
