"""One judge for all claims: it sees measured values and their places, not what they were measured on."""

import math
from typing import Any

import pytest
from facts import raises
from hypothesis import example, given
from hypothesis import strategies as st

from maglev.files.errors import MeasurementError
from maglev.runs.verdicts import (
    DIFFERENCE,
    VERDICTS,
    ClaimResult,
    MeasuredValue,
    bound_claims,
    bounds_in_words,
    bounds_met,
    count_verdicts,
    judge,
    least_ratio,
    met_of,
    of_modified_runs,
    ratio,
    sentences,
    specification,
)
from maglev.scenario.claims import Claim, ProcedureClaim, RunClaim

WORDS = {"text": "a claim", "source": "p. 1"}

numbers = st.integers(0, 4000).map(lambda quarters: quarters / 4)   # exact in binary


def about_a_run(**table: Any) -> Claim:
    return RunClaim.model_validate({**WORDS, "metric": "overshoot", **table})


def about_a_procedure(**table: Any) -> Claim:
    return ProcedureClaim.model_validate({**WORDS, "value": "thrust", **table})


def values(*numbers: float) -> list[MeasuredValue]:
    """Values each at a place of its own."""
    return [MeasuredValue(number, ("y", float(k))) for k, number in enumerate(numbers)]


@given(st.lists(numbers, min_size=1, max_size=4), numbers, st.sampled_from(["<", ">", "about"]),
       st.sampled_from(["all", "any", "mean"]))
def test_a_claim_with_a_target_is_judged_alike_whatever_it_is_about(measured, target, relation, over) -> None:
    table = {"relation": relation, "target": target, "over": over} | ({"digits": 2} if relation == "about" else {})
    run, procedure = (judge(make(**table), values(*measured)) for make in (about_a_run, about_a_procedure))
    assert (run.verdict, run.measured, run.against) == (procedure.verdict, procedure.measured, None)


@given(st.lists(numbers, min_size=1, max_size=4), numbers, st.sampled_from(["<", ">"]))
def test_all_is_the_worst_and_any_the_best(measured, target, relation) -> None:
    def decided(over: str) -> ClaimResult:
        return judge(about_a_run(relation=relation, target=target, over=over), values(*measured))

    met = [number < target if relation == "<" else number > target for number in measured]
    assert (decided("all").verdict == "reproduced") is all(met)
    assert (decided("any").verdict == "reproduced") is any(met)
    worst, best = (max, min) if relation == "<" else (min, max)
    assert (decided("all").measured, decided("any").measured) == (worst(measured), best(measured))


@given(numbers, st.floats(0.1, 1e3), st.floats(0.1, 10.0), st.sampled_from(["<", ">"]))
@example(25.0, 26.0, 1.0, "<")
@example(26.0, 25.0, 1.0, ">")
def test_a_comparison_is_judged_alike_whatever_it_is_about(own, other, factor, relation) -> None:
    run = judge(about_a_run(relation=relation, factor=factor, than="fast"), values(own), values(other))
    procedure = judge(about_a_procedure(relation=relation, factor=factor, than={"epsilon": 0.01}), values(own),
                      values(other))
    assert (run.verdict, run.measured, run.against) == (procedure.verdict, own, other)
    passed = factor if factor != 1.0 else {"<": 1.0 / 1.05, ">": 1.05}[relation]   # more or less is by 5 %
    met = own / other < passed if relation == "<" else own / other > passed
    assert (run.verdict == "reproduced") is (met and own / other != passed)


def test_only_values_with_a_counterpart_are_compared() -> None:
    claim = about_a_run(relation="<", than="fast", over="mean")
    here = [MeasuredValue(1.0, ("y", 1.0)), MeasuredValue(3.0, ("y", 2.0)), MeasuredValue(9.0, ("x", 1.0))]
    there = [MeasuredValue(8.0, ("y", 2.0)), MeasuredValue(4.0, ("y", 1.0)), MeasuredValue(0.0, ("z", 1.0))]
    result = judge(claim, here, there)
    assert (result.verdict, result.measured, result.against) == ("reproduced", 2.0, 6.0)
    with raises(MeasurementError, "'a claim'", "fast", "overshoot"):
        judge(claim, here, there[2:])


@pytest.mark.parametrize("make", [about_a_run, about_a_procedure])
def test_a_missing_run_has_no_verdict(make: Any) -> None:
    claim = make(relation="<", target=1)
    assert judge(claim, None) == ClaimResult(claim, None, "not run")


def test_a_comparison_needs_both_sides() -> None:
    claim = about_a_run(relation="<", than="fast")
    for here, there in ((values(1.0), None), (None, values(1.0)), (None, None)):
        assert judge(claim, here, there).verdict == "not run"


def test_every_verdict_is_counted() -> None:
    claim = about_a_run(relation="<", target=1)
    results = [ClaimResult(claim, None, verdict) for k, verdict in enumerate(VERDICTS) for _ in range(k)]
    assert list(count_verdicts(results).items()) == [(verdict, k) for k, verdict in enumerate(VERDICTS)]
    assert sum(count_verdicts([]).values()) == 0


@given(st.lists(numbers, min_size=1, max_size=4), numbers, numbers, st.sampled_from(["all", "any", "mean"]))
def test_a_range_is_met_when_all_any_or_the_mean_lie_in_it(measured, low, width, over) -> None:
    claim = ProcedureClaim.model_validate(
        {"figure": "4.9", "value": "thrust", "target": [low, low + width + 1.0], "over": over})
    inside = [low <= value <= low + width + 1.0 for value in measured]
    expected = {"all": all(inside), "any": any(inside),
                "mean": low <= sum(measured) / len(measured) <= low + width + 1.0}[over]
    assert judge(claim, values(*measured)).verdict == ("met" if expected else "not met")


@pytest.mark.parametrize(("over", "decides"), [("all", 9.0), ("any", 5.0), ("median", 5.0), ("mean", 5.5)])
def test_of_values_about_a_range_the_farthest_beyond_it_decides(over: str, decides: float) -> None:
    """Below by 2, within, and above by 3."""
    claim = ProcedureClaim.model_validate({"figure": "4.9", "value": "thrust", "target": [4.0, 6.0], "over": over})
    measured = [2.0, 5.0, 9.0] if over != "mean" else [2.0, 9.0]
    assert judge(claim, values(*measured)).measured == decides
    assert judge(claim, values(*(10.0 - value for value in measured))).measured == 10.0 - decides   # mirrored at 5


def test_counts_axis_range_checks_apart_from_claims_in_words() -> None:
    words = about_a_run(relation="<", target=1.0)
    bound = ProcedureClaim.model_validate({"figure": "4.9", "value": "thrust", "target": [1, 2]})
    results = [ClaimResult(words, 0.5, "reproduced"), ClaimResult(bound, 1.5, "met"),
               ClaimResult(bound, 3.0, "not met"), ClaimResult(bound, None, "not run")]
    assert sentences(results) == results[:1]
    assert bound_claims(results) == results[1:]
    assert (bounds_met(results), bounds_met(results[:1])) == ("1 of 2", "")
    assert bounds_in_words(results) == "1 of 2 axis-range checks are met"
    assert bounds_in_words(results[:1]) == ""


def test_counts_axis_range_checks_whose_figure_chose_a_parameter() -> None:
    bound = {"figure": "4.9", "value": "thrust", "target": [1, 2]}
    plain, chose = (ProcedureClaim.model_validate({**bound, **more}) for more in ({}, {"chose": "the stops"}))
    results = [judge(claim, values(value)) for claim, value in ((plain, 1.5), (chose, 1.5), (chose, 3.0))]
    assert bounds_in_words(results) == ("2 of 3 axis-range checks are met, 1 of these 2 with a figure that was used to "
                                        "choose a parameter")
    assert results[1].note == "not independent: the figure was used to choose the stops"
    assert results[0].note == ""


def test_a_users_own_claims_are_counted_apart() -> None:
    mine = about_a_run(relation="<", target=1.0, own=True)
    bound = ProcedureClaim.model_validate({"figure": "4.9", "value": "thrust", "target": [1, 2], "own": True})
    results = [judge(mine, values(0.5)), judge(mine, values(1.0)), judge(bound, values(1.5)), judge(mine, None)]
    assert [result.verdict for result in results] == ["met", "not met", "met", "not run"]
    assert (specification(results), sentences(results), bound_claims(results)) == (results, [], [])
    assert met_of(results) == "2 of 3"
    assert of_modified_runs(results) == results, "whichever controller runs"


def test_a_modified_run_has_no_verdict_on_the_thesis_but_on_what_is_the_users_own() -> None:
    claim, mine = about_a_run(relation="<", target=1.0), about_a_run(relation="<", target=1.0, own=True)
    results = [ClaimResult(claim, 0.5, "reproduced"), ClaimResult(claim, 3.0, "not reproduced"),
               ClaimResult(claim, None, "not run"), ClaimResult(claim, None, "not testable"),
               ClaimResult(mine, 0.5, "met")]
    modified = of_modified_runs(results)
    assert [result.verdict for result in modified] == ["modified run", "modified run", "not run", "not testable", "met"]
    assert [result.measured for result in modified] == [result.measured for result in results]
    assert [result.claim for result in modified] == [result.claim for result in results]


@pytest.mark.parametrize(("relation", "factor", "own", "asked"), [
    (">", 1.0, False, DIFFERENCE), ("<", 1.0, False, 1.0 / DIFFERENCE), (">", 1.0, True, 1.0), ("<", 1.0, True, 1.0),
    (">", 1.5, False, 1.5), ("<", 0.5, False, 0.5)])
def test_more_and_less_ask_for_a_difference_a_factor_for_itself(
        relation: str, factor: float, own: bool, asked: float) -> None:
    claim = about_a_run(relation=relation, than="2dof-smooth-pid", factor=factor, own=own)
    assert least_ratio(claim) == asked


def test_nothing_against_nothing_is_the_same() -> None:
    assert [ratio(3.0, 2.0), ratio(0.0, 0.0), ratio(math.inf, math.inf), ratio(1.0, 0.0)] == [1.5, 1.0, 1.0, math.inf]


def test_of_values_about_a_target_the_farthest_decides() -> None:
    result = judge(about_a_run(relation="about", target=2.0), values(2.02, 1.0, 2.5))
    assert (result.measured, result.verdict) == (1.0, "not reproduced")
