"""The input files of the closed loops: no row at a place where a rounding error decides."""

import numpy as np
import pytest

from maglev.scenario.layers import PACKAGED


@pytest.mark.parametrize(("file", "step"), [("2dof-setpoints.csv", 5e-4), ("3dof-setpoints.csv", 2e-4)])
def test_any_clock_finds_the_same_row(file: str, step: float) -> None:
    """Clocks that multiply, that add up, and that are off by picoseconds, at every communication point."""
    times = np.genfromtxt(PACKAGED / "inputs" / file, delimiter=",", names=True, deletechars="")["time"]
    exact = np.arange(round(26.0 / step) + 1) * step
    added = np.concatenate([[0.0], np.cumsum(np.full(len(exact) - 1, step))])
    rows = [np.searchsorted(times, clock, side="right") - 1
            for clock in (exact, added, exact + 1e-12, np.maximum(exact - 1e-12, 0.0))]
    assert rows[0][-1] == len(times) - 1 > 2
    for other in rows[1:]:
        assert np.array_equal(rows[0], other)
    # A row takes effect at the whole second that its reference steps at.
    starts = exact[np.flatnonzero(np.diff(rows[0])) + 1]
    assert np.allclose(starts, np.round(starts), rtol=0.0, atol=1e-9)
