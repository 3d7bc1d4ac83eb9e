"""What follows from a stage, as it is printed: within 80 columns, amperes as peaks, and at which gap."""

import re
from dataclasses import replace
from itertools import pairwise
from math import inf

import pytest

from maglev.descriptions.packaged import PACKAGED_STAGES, SINGLE
from maglev.user.consequences import Consequences, Place, peaks_of
from maglev.user.scenario_loop import loop_table, setpoints, settling_band


def consequences_of(name: str, sheet: str = "") -> Consequences:
    """Of a stage, with numbers as long as they come."""
    stage = PACKAGED_STAGES[name]
    margins = dict.fromkeys(stage.axis_names, (48.123, 10.4))
    start, below, above = (Place(gap, dict.fromkeys(stage.motor_names, current) if current else {}, 126.4, force,
                                 margins if current else {})
                           for gap, current, force in ((0.025, -0.00755, 51.2), (0.0185, 4.88, -11.8), (0.032, 0.0, 1)))
    forces = {f"thrust {axis.name}": 19.65 for axis in stage.horizontal} | {"normal": 22.96, "attraction": 126.4}
    return Consequences(stage, forces, dict.fromkeys(stage.motor_names, 14.14), inf, 36.5, 2e-4, (start, below, above),
                        sheet)


@pytest.mark.parametrize("name", PACKAGED_STAGES)
def test_text_fits_80_columns_and_parts_no_number_from_its_unit(name: str) -> None:
    text = str(consequences_of(name))
    assert max(map(len, text.splitlines())) <= 80
    assert "32 mm: no direct current holds the mover" in " ".join(text.split())
    assert not re.search(r"\d\n +(?:N|N/A|A|mm|ms|1/s)\b", text)
    rows = [re.split(" {2,}", line) for line in text.splitlines()]
    assert ["gap", "25 mm", "18.5 mm", "32 mm"] in rows
    assert all([f"margins of {axis}", "48°, 10.4 dB", "48°, 10.4 dB", "–"] in rows
               for axis in PACKAGED_STAGES[name].axis_names)


def test_rms_amperes_of_a_data_sheet_are_said_as_peaks() -> None:
    sheet = peaks_of({"catalogue": {"currents": "rms", "peak": "10 A", "force_constant": 74.6, "at": "0.9 mm"}}, 0.02)
    assert sheet == ("peak of 10 A rms = 14.1 A; force constant of 74.6 N/A rms = 52.75 N per ampere of peak current, "
                     "of one motor at a gap of 0.9 mm")
    assert peaks_of({"catalogue": {"currents": "peak", "peak": 10}}, 0.02) == ""
    text = " ".join(str(consequences_of("2dof", sheet)).split())
    assert "data sheet peak of 10 A rms = 14.1 A" in text
    assert "i_d = -0.00755 A of at most 14.1 A (10 A rms)" in text
    assert "per ampere of peak current" in text


def test_band_of_small_setpoints_is_less_than_their_steps() -> None:
    axis = PACKAGED_STAGES[SINGLE].vertical
    assert axis.stop is not None
    stop = replace(axis.stop, lower=axis.start - 3e-4, upper=axis.start + 3e-4)
    stage = replace(PACKAGED_STAGES[SINGLE], axes=(replace(axis, stop=stop), *PACKAGED_STAGES[SINGLE].horizontal),
                    resolution=1e-6)
    moves = {abs(after - before) for values in setpoints(stage).values() for before, after in pairwise(values)}
    assert 1e-3 * min(moves) < 1e-4, "smaller than the band of other stages"
    assert stage.resolution <= settling_band(stage) < 1e-3 * min(moves)
    assert loop_table(stage)["metrics"]["bands"][0] == settling_band(stage)
    assert {settling_band(stage) for stage in PACKAGED_STAGES.values()} == {1e-4}
