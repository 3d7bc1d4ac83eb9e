"""Colours of the report's lines, as people see them who tell red from green badly, and against the paper."""

import re
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest

from maglev.pages import lines as plot_lines
from maglev.pages.figures import COLOURS
from maglev.pages.live_content import LAW_COLOURS, LAWS
from maglev.pages.picture import STYLES
from maglev.pages.shell import read

# What is drawn in one panel: lines of runs, phases of a motor, direct and quadrature current.
GROUPS = (tuple(f"run-{k}" for k in range(7)), tuple(f"phase-{k}" for k in range(3)), ("direct", "quadrature"))

# Machado, Oliveira and Fernandes (2009), severity 1, of linear RGB.
SEEN_BY = {
    "trichromats": np.eye(3),
    "protanopes": np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
                            [-0.003882, -0.048116, 1.051998]]),
    "deuteranopes": np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
                              [-0.011820, 0.042940, 0.968881]]),
}
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
WHITE = np.array([0.95047, 1.0, 1.08883])


def linear(colour: str) -> np.ndarray:
    """Linear RGB of "#rrggbb"."""
    values = np.array([int(colour[k:k + 2], 16) / 255 for k in (1, 3, 5)])
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def lab(rgb: np.ndarray) -> np.ndarray:
    """CIE L*a*b* of linear RGB."""
    share = TO_XYZ @ np.clip(rgb, 0.0, 1.0) / WHITE
    x, y, z = np.where(share > 0.008856, np.cbrt(share), 7.787 * share + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def luminance(colour: str) -> float:
    return float(TO_XYZ[1] @ linear(colour))


@pytest.fixture(params=["light", "dark"])
def scheme(request) -> dict[str, str]:
    """Colours of a scheme by name."""
    first, second = re.findall(r":root \{(.*?)\}", read("tokens.css"), re.DOTALL)[:2]
    return dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6})", first if request.param == "light" else second))


@pytest.mark.parametrize("who", SEEN_BY)
def test_lines_of_a_panel_are_told_apart(scheme, who):
    for group in GROUPS:
        for one, other in combinations([*group, "thesis"], 2):
            seen = [lab(SEEN_BY[who] @ linear(scheme[name])) for name in (one, other)]
            assert np.linalg.norm(seen[0] - seen[1]) > 20.0, (one, other)   # of two greys 20 % of black to white


def test_a_colour_has_one_meaning(scheme):
    meanings = [name for group in GROUPS for name in group]
    assert len({scheme[name] for name in [*meanings, "reference", "limit", "thesis"]}) == len(meanings) + 3


def test_axes_and_currents_have_colours_that_no_controller_has(scheme):
    """On the live page all are seen next to each other."""
    ours, theirs = [*(f"axis-{k}" for k in range(5)), "current"], [*GROUPS[0], "bad", "reference", "limit", "weight"]
    for one, other in [*combinations(ours, 2), *product(ours, theirs)]:
        assert np.linalg.norm(lab(linear(scheme[one])) - lab(linear(scheme[other]))) > 20.0, (one, other)


def test_a_controller_has_a_colour_of_its_own_and_so_has_one_of_the_readers():
    assert LAW_COLOURS.keys() == {*LAWS.values()}
    assert len({1, *LAW_COLOURS.values()}) == len(LAWS) + 1 == COLOURS == len(GROUPS[0])


def test_regulators_that_are_compared_differ_in_hue(scheme):
    """Two blues are far apart by their lightness, and yet both are "the blue one"."""
    one, other = (lab(linear(scheme[f"run-{LAW_COLOURS[law]}"])) for law in ("nonlinear", "interpolated"))
    hues = np.degrees([np.arctan2(colour[2], colour[1]) for colour in (one, other)])
    assert abs((hues[1] - hues[0] + 180.0) % 360.0 - 180.0) > 45.0


def test_lines_stand_out_from_the_paper(scheme):
    for name in [*(name for group in GROUPS for name in group), "reference", "limit", "thesis"]:
        bright, dim = sorted((luminance(scheme[name]), luminance(scheme["paper"])), reverse=True)
        assert (bright + 0.05) / (dim + 0.05) > 3.0, name   # WCAG 2.1, 1.4.11


def test_scripts_use_no_colour_that_the_style_lacks(scheme):
    folder = Path(__file__).parents[3] / "maglev" / "pages" / "report"
    used = {name for path in folder.rglob("*.js") for name in re.findall(r"var\(--([a-z]+)\)", path.read_text())}
    assert used
    assert used <= scheme.keys()


def test_runs_have_dashes_that_nothing_else_has() -> None:
    """Without colour, as on grey paper: references and limits have others, and scripts those of pictures."""
    script = (Path(plot_lines.__file__).parent / "report/plots/plots.js").read_text(encoding="utf-8")
    named = Path(plot_lines.__file__).read_text(encoding="utf-8")
    of_runs, marked = re.findall(r"const (?:RUN_DASHES|MARKED) = (.*);", script)
    assert tuple(re.findall(r'"(\w+)"', of_runs)) == plot_lines.DASHES
    others = {*re.findall(r'dash: "(\w+)"', marked), *re.findall(r'"(?:reference|limit)", "((?!ref)\w+)"', named)}
    assert others == {"dot", "dashdot"}
    assert not others & {*plot_lines.DASHES} and {*others, *plot_lines.DASHES} == {*STYLES}
