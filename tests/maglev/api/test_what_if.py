"""Runs behind claims that blame friction, run again without it, of a user's own scenario."""

from pathlib import Path

import maglev
from maglev.runs.measures import measures_of
from maglev.scenario.quantities import printed

NOTHING = {f"plant.{axis}.friction.{kind}": 0.0 for axis in "vh" for kind in ("coulomb", "viscous")}

# Friction of the plant's own defaults; the first reason blames it, the second not, the third claim is met.
OWN = """
extends = ["loops/2dof.toml", "references/2dof-tracking.toml", "gains/2dof.toml"]
name = "own"
title = "An own scenario"
stop_time = "1.5 s"
metrics = { tracking_from = "1 s" }

[[claims]]
text = "It tracks within 50 µm"
source = "nowhere"
metric = "peak_tracking_error"
axis = "h"
relation = "<"
target = "50 um"
because = "friction"
reason = "the guides are rough"

[[claims]]
text = "It tracks within 1 nm"
source = "nowhere"
metric = "peak_tracking_error"
axis = "h"
relation = "<"
target = "0.001 um"
reason = "a joke"

[[claims]]
text = "It tracks at all"
source = "nowhere"
metric = "peak_tracking_error"
axis = "h"
relation = "<"
target = "1 m"
because = "friction"
reason = "the guides are rough"
"""


def peak(run: maglev.Run) -> float:
    """Largest tracking error of h, m."""
    value, = [each.value for each in measures_of(run.plan, run.metrics)
              if (each.quantity, each.of) == ("peak tracking error", "h")]
    return value


def test_runs_blamed_on_friction_are_repeated_without_it(fastest_fmus: Path, tmp_path: Path) -> None:
    own, out = tmp_path / "own.toml", tmp_path / "out"
    own.write_text(OWN, encoding="utf-8")
    maglev.run_all([own], out=out, fmus=fastest_fmus, page=True, jobs=1)
    again = (out / "without-friction" / "own.json").read_text(encoding="utf-8")
    expected = peak(maglev.run(own, fmus=fastest_fmus, set=NOTHING))
    assert 0.0 < expected < 0.5 * peak(maglev.run(own, fmus=fastest_fmus))
    assert all(f"{name} = 0 instead of" in again for name in NOTHING)
    page = (out / "report.html").read_text(encoding="utf-8")
    assert page.count("<summary>What if friction were zero?") == 2   # in the table, and under the figure
    text = printed(expected, "m").replace(" ", "\N{NO-BREAK SPACE}")
    assert f"met</span>: {text}." in page


def test_nothing_is_run_twice_without_a_reason_or_a_wish(fastest_fmus: Path, tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text(OWN.replace('because = "friction"', ""), encoding="utf-8")
    maglev.run_all([own], out=tmp_path / "a", fmus=fastest_fmus, page=True, jobs=1)
    own.write_text(OWN, encoding="utf-8")
    maglev.run_all([own], out=tmp_path / "b", fmus=fastest_fmus, page=True, what_if=False, jobs=1)
    maglev.run_all([own], out=tmp_path / "c", fmus=fastest_fmus, jobs=1)
    assert not list(tmp_path.glob("*/without-friction"))
