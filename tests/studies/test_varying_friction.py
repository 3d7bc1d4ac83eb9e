"""The study of friction that varies along the guide: likelihood and errors by hand, the rule, and the page."""

import math
import re

import numpy as np
import pytest

from maglev.descriptions.packaged import PACKAGED_STAGES
from studies.estimation import DOCS, read_settings
from studies.varying_friction import decision, difference, log_likelihoods, varying

pytestmark = pytest.mark.quick


def test_the_likelihood_is_the_mean_over_tracks_and_the_product_over_experiments() -> None:
    misfits = {"a": np.array([0.0, math.log(3.0)]), "b": np.array([800.0, 800.0])}
    assert log_likelihoods(misfits) == pytest.approx([math.log(2.0 / 3.0), -800.0])


def test_the_error_over_experiments_is_that_of_a_sum_of_independent_ones() -> None:
    """With one track: n times the variance of one experiment."""
    generator = np.random.default_rng(1)
    values = generator.normal(2.0, 1.0, 40)
    today = {str(k): np.array([5.0]) for k in range(40)}
    found, error = difference({str(k): np.array([5.0 - value]) for k, value in enumerate(values)}, today)
    assert found == pytest.approx(values.sum())
    assert error == pytest.approx(math.sqrt(40.0 * values.var(ddof=1)))


def test_the_error_over_tracks_is_that_of_the_logarithm_of_a_mean() -> None:
    """By propagation: the variance of exp(−misfit) over n, as a share of its mean; experiments that agree add none."""
    likelihoods = np.random.default_rng(2).uniform(0.9, 1.1, 50)
    of_track = -np.log(likelihoods)
    found, error = difference({"a": of_track, "b": of_track}, {"a": np.zeros(1), "b": np.zeros(1)})
    assert found == pytest.approx(2.0 * math.log(likelihoods.mean()))
    assert error == pytest.approx(2.0 * likelihoods.std(ddof=1) / math.sqrt(50.0) / likelihoods.mean(), rel=0.01)


@pytest.mark.parametrize(("held_out", "parabolas", "expected"), [
    ((2.1, 1.0), (-1.9, 1.0), "replaces roughness"), ((2.1, 1.0), (-2.1, 1.0), "rejected"),
    ((1.9, 1.0), (9.0, 1.0), "undecided"), ((-2.1, 1.0), (9.0, 1.0), "rejected"),
    ((-1.9, 1.0), (0.0, 1.0), "undecided")])
def test_the_rule_decides_by_two_standard_errors(
        held_out: tuple[float, float], parabolas: tuple[float, float], expected: str) -> None:
    assert decision(held_out, parabolas) == expected


def test_the_page_decides_by_its_own_numbers_and_the_plants_follow() -> None:
    """The bold combination has the largest likelihood, and its D and P give the decision of the page."""
    text = DOCS.read_text(encoding="utf-8").partition("<!-- varying friction")[2]
    table = [float(each) for each in re.findall(r"[| *](-\d+\.\d)", text.partition("| candidate")[0])]
    assert len(table) == 24 and f"**{max(table):.1f}**" in text
    numbers = re.search(r"\| × [^|]*± [^|]*\| (-?[\d.]+) ± ([\d.]+) \| (-?[\d.]+) ± ([\d.]+) \|", text)
    assert numbers is not None
    d, d_error, p, p_error = map(float, numbers.groups())
    assert f"The decision is **{decision((d, d_error), (p, p_error))}**" in text
    varied = [axis.friction.variation for stage in PACKAGED_STAGES.values() for axis in stage.axes]
    assert any(varied) == ("**replaces roughness**" in text)


def test_a_candidate_names_a_level_and_a_length_for_every_axis_that_friction_is_assumed_of() -> None:
    settings = read_settings()
    effects = varying(settings, 0.75, 0.4, 8e-3).effects
    assert len(effects) == 2 * len(settings.assumed) and effects["Plant3DOF.z.friction.variation"] == 0.4
