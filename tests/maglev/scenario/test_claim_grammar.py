"""What claims about runs and about procedures can say, and what they cannot: one grammar for both."""

from typing import Any

import pytest
from pydantic import ValidationError

from maglev.scenario.claims import Claim, ProcedureClaim, RunClaim
from maglev.scenario.quantities import METRICS, PRINTED_UNITS, PROCEDURE_VALUES

# A claim of each kind about a number with a unit, and how it compares with another place.
RUN: dict[str, Any] = {"metric": "peak_current", "relation": "<", "target": "2 A"}
PROCEDURE = {"value": "equilibrium_deviation", "relation": "<", "target": "2 A"}
BOTH: list[tuple[dict[str, Any], Any]] = [(RUN, "fast"), (PROCEDURE, {"epsilon": 0.01})]
both_kinds = pytest.mark.parametrize(("base", "than"), BOTH, ids=["run", "procedure"])

OVERSHOOT: dict[str, Any] = {"metric": "overshoot", "relation": "<", "target": "30 %"}
FORCE: dict[str, Any] = {"value": "cogging_force", "relation": "<", "target": "2 N"}


def claim(cls: type[Claim] | None = None, **table: Any) -> Claim:
    """Claim about a procedure if it has a value, else about a run."""
    cls = cls or (ProcedureClaim if "value" in table else RunClaim)
    return cls.model_validate({"text": "a claim", "source": "p. 1", **table})


def refusal(cls: type[Claim] | None = None, **table: Any) -> str:
    """What is said first against a table."""
    with pytest.raises(ValidationError) as caught:
        claim(cls, **table)
    return str(caught.value.errors()[0])


@both_kinds
@pytest.mark.parametrize(("change", "words"), [
    ({"relation": None}, ["'relation'", "required for the"]),
    ({"target": None}, ["'target'", "required for the"]),
    ({"digits": 2}, ["'digits'", "has no meaning for the"]),
    ({"relation": "is"}, ["'relation'", "expected < or > or about for the"]),
    ({"relation": "="}, ["relation", "'about'"]),
    ({"factor": 2.0}, ["'factor'", "has no meaning without than"]),
    ({"factor": 0}, ["factor", "greater than 0"]),
    ({"factor": "significantly", "relation": "about"}, ["'factor'", "expected the relation < or >"]),
    ({"kind": "verdict"}, ["kind", "'number', 'ordering', 'specification' or 'survival'"]),
    ({"assumed": 1}, ["assumed", "boolean"]),
    ({"over": "most"}, ["over", "'mean'"]),
    ({"target": "2 m"}, ["target", "2 m", "in A"]),
    ({"target": True}, ["target", "True is not a quantity"]),
    ({"target": [1]}, ["target", "[1]"]),
    ({"target": float("nan")}, ["target", "nan"]),
    ({"not_testable": "no stage"}, ["'not_testable'", "got both"]),
    ({"axis": "x", "axes": ["x"]}, ["'axis'", "got both"]),
    ({"tarset": 1}, ["tarset", "nearest is 'target'"])])
def test_rules_of_every_claim(base: dict[str, Any], than: Any, change: dict[str, Any], words: list[str]) -> None:
    table = {key: value for key, value in {**base, **change}.items() if value is not None}
    message = refusal(**table)
    assert all(word in message for word in words), message


@both_kinds
@pytest.mark.parametrize(("change", "words"), [
    ({"target": 1}, ["'target'", "has no meaning for the", "with than"]),
    ({"relation": "about", "digits": 1}, ["'relation'", "expected < or > for the"]),
    ({"relation": "is"}, ["'relation'", "expected < or > for the"])])
def test_rules_of_every_comparison(base: dict[str, Any], than: Any, change: dict[str, Any],
                                   words: list[str]) -> None:
    table = {key: value for key, value in base.items() if key != "target"} | {"than": than}
    assert claim(**table, factor=2.0).comparative
    assert not claim(**base).comparative
    message = refusal(**{**table, **change})
    assert all(word in message for word in words), message


@pytest.mark.parametrize("kind", [RunClaim, ProcedureClaim])
@pytest.mark.parametrize(("table", "words"), [
    ({}, ["or not_testable with the reason"]),
    ({"not_testable": "no stage", "relation": "<"}, ["'relation'", "has no meaning for a claim that is not testable"]),
    ({"not_testable": "no stage", "axes": ["x"]}, ["'axes'", "has no meaning for a claim that is not testable"]),
    ({"not_testable": "no stage", "target": 1}, ["target", "has no meaning without a"])])
def test_a_claim_that_is_not_testable_says_nothing_else(kind: type[Claim], table: dict[str, Any],
                                                        words: list[str]) -> None:
    message = refusal(kind, **table)
    assert all(word in message for word in words), message
    bare = claim(kind, not_testable="no stage")
    assert (bare.criterion, bare.printed(None), bare.comparative, bare.measured) == ("", "", False, None)


@pytest.mark.parametrize(("table", "words"), [
    ({**OVERSHOOT, "metric": "overshoots"}, ["metric", "'settling_time', 'overshoot'", "nearest is 'overshoot'"]),
    ({**OVERSHOOT, "metric": 3}, ["metric", "'highest' or 'largest'"]),
    ({**OVERSHOOT, "metric": "cogging_force"}, ["metric", "'highest' or 'largest'"]),
    ({**OVERSHOOT, "metric": "settling_time", "target": 1}, ["'band'", "required"]),
    ({**OVERSHOOT, "band": 1}, ["'band'", "no meaning"]),
    ({**OVERSHOOT, "motor": "alpha"}, ["'motors'", "no meaning"]),
    ({**OVERSHOOT, "motor": "alpha", "motors": ["alpha"]}, ["'motor'", "got both"]),
    ({**OVERSHOOT, "because": "friction"}, ["'because'", "expected a reason"]),
    ({**OVERSHOOT, "reason": "rough guides", "because": "frictoin"}, ["because", "'friction'"]),
    ({**OVERSHOOT, "axi": "y"}, ["axi", "nearest is 'ax"]),
    ({**OVERSHOOT, "target": "3 s"}, ["target", "3 s"]),
    ({**RUN, "axis": "y"}, ["'axes'", "no meaning"]),
    ({"metric": "failed", "relation": "is", "target": True, "axis": "y"}, ["'axes'", "no meaning"]),
    ({"metric": "failed", "relation": "<", "target": True}, ["'relation'", "expected is for"]),
    ({"metric": "failed", "relation": "is", "target": 1}, ["target", "true or false for the metric failed"]),
    ({"metric": "failed", "relation": "is"}, ["'target'", "required"]),
    ({"metric": "failed", "relation": "is", "than": "fast"}, ["than", "a metric that is a number"]),
    ({"metric": "peak_current", "relation": "<", "than": "fast", "than_axis": "x"}, ["'than_axis'", "no meaning"])])
def test_rules_of_claims_about_runs(table: dict[str, Any], words: list[str]) -> None:
    message = refusal(**table)
    assert all(word in message for word in words), message


@pytest.mark.parametrize(("table", "words"), [
    ({**FORCE, "value": "cogging_farce"}, ["value", "nearest is 'cogging_force'"]),
    ({**FORCE, "value": "overshoot"}, ["value", "or 'speed_deviation'"]),
    ({**FORCE, "value": "equilibrium_deviation"}, ["target", "2 N", "in A"]),
    ({**FORCE, "value": "constant", "constant": "C1", "target": "14 A"}, ["target", "14 A"]),
    ({**FORCE, "value": "constant", "target": 14}, ["'constant'", "required for the value constant"]),
    ({**FORCE, "value": "average_constant", "target": 14}, ["'constant'", "required"]),
    ({**FORCE, "value": "constant", "constant": "C9", "target": 14}, ["constant", "C9"]),
    ({**FORCE, "constant": "C2"}, ["'constant'", "has no meaning for the value cogging_force"]),
    ({**FORCE, "epsilon": "1 m"}, ["epsilon", "1 m", "in s"]),
    ({**FORCE, "gap": ["1 mm", "2 mm"]}, ["gap", "nearest is 'gaps'"]),
    ({**FORCE, "gaps": ["15 mm", "10 mm"]}, ["gaps", "the smaller air gap first"]),
    ({**FORCE, "motor": "alpha"}, ["motor", "unknown key"]),
    ({"value": "thrust", "relation": "<", "than": {"epsilo": 1}}, ["epsilo", "nearest is 'epsilon'"]),
    ({"value": "thrust", "relation": "<", "than": {}}, ["than", "expected epsilon, gaps or both"])])
def test_rules_of_claims_about_procedures(table: dict[str, Any], words: list[str]) -> None:
    message = refusal(**table)
    assert all(word in message for word in words), message


@pytest.mark.parametrize(("table", "target", "criterion"), [
    (OVERSHOOT, 0.3, "overshoot < 30 %"),
    ({**OVERSHOOT, "metric": "settling_time", "band": "0.1 mm", "target": "5 s"}, 5.0,
     "settling time to 0.1 mm < 5 s"),
    ({"metric": "lost_setpoints", "relation": "about", "target": 2, "digits": 1}, 2.0,
     "lost setpoints about 2"),
    ({"metric": "failed", "relation": "is", "target": False}, False, "kept the stage in the air"),
    ({"metric": "overshoot", "relation": "<", "than": "fast"}, None, "overshoot < that of fast"),
    ({"metric": "overshoot", "relation": "<", "than": "fast", "factor": 0.5}, None, "overshoot < 0.5 × that of fast"),
    ({"metric": "overshoot", "axis": "y", "relation": ">", "than_axis": "x"}, None, "overshoot of y > that of x"),
    ({"metric": "overshoot", "axis": "y", "relation": ">", "than": "fast", "than_axis": "x"}, None,
     "overshoot of y > that of x of fast"),
    (FORCE, 2.0, "cogging force < 2 N"),
    ({**FORCE, "target": 2, "gaps": ["10 mm", "14.5 mm"]}, 2.0, "cogging force, gap 10 to 14.5 mm < 2 N"),
    ({**FORCE, "gaps": ["1 cm", "10 mm"]}, 2.0, "cogging force, gap 10 mm < 2 N"),
    ({**FORCE, "value": "equilibrium_deviation", "target": "200 mA"}, 0.2, "equilibrium deviation < 0.2 A"),
    ({**FORCE, "value": "estimator_deviation", "target": "5 %", "epsilon": "10 ms"}, 0.05,
     "estimator deviation, ε = 0.01 s < 5 %"),
    ({"value": "constant", "constant": "C3", "relation": "about", "target": 31.04, "digits": 3}, 31.04,
     "C3 about 31.04"),
    ({"value": "average_constant", "constant": "C1", "relation": "about", "target": 0.6739, "digits": 3}, 0.6739,
     "average constant C1 about 0.6739"),
    ({**FORCE, "over": "mean"}, 2.0, "mean cogging force < 2 N"),
    ({"value": "estimator_deviation", "epsilon": "0.05 s", "relation": ">", "than": {"epsilon": "0.01 s"}}, None,
     "mean estimator deviation, ε = 0.05 s > that, ε = 0.01 s"),
    ({"value": "equilibrium_deviation", "gaps": ["17 mm", "20 mm"], "relation": "<", "factor": 2,
      "than": {"gaps": ["21 mm", "30 mm"]}}, None,
     "mean equilibrium deviation, gap 17 to 20 mm < 2 × that, gap 21 to 30 mm")])
def test_targets_are_si_and_the_criterion_says_what_is_judged(table: dict[str, Any], target: float | None,
                                                              criterion: str) -> None:
    made = claim(**table)
    assert made.target == (None if target is None else pytest.approx(target))
    assert made.criterion == criterion


def test_one_name_is_a_list_of_it() -> None:
    assert claim(**FORCE, axis="x").axes == claim(**OVERSHOOT, axis="x").axes == ["x"]
    assert claim(**FORCE).axes is None
    about_motors = claim(**RUN, motor="beta")
    assert isinstance(about_motors, RunClaim)
    assert about_motors.motors == ["beta"]


def test_quantities_are_told_apart_and_have_units_to_print() -> None:
    assert not set(METRICS) & set(PROCEDURE_VALUES)
    for quantity in [*METRICS.values(), *PROCEDURE_VALUES.values()]:
        assert quantity.unit in {None, "s", "A", "N", "J", *PRINTED_UNITS}
        assert not (quantity.yes_no and quantity.unit)
    assert {quantity.on == "procedure" for quantity in METRICS.values()} == {False}
    assert {quantity.on for quantity in PROCEDURE_VALUES.values()} == {"procedure"}


@pytest.mark.parametrize(("name", "value", "text"), [
    ("overshoot", 0.3234, "32.3 %"), ("mean_tracking_error", 0.0592e-3, "59.2 µm"), ("settling_time", 4.0, "4 s"),
    ("settling_time", float("inf"), "not settled"), ("trip_time", float("inf"), "never"),
    ("failed", True, "lost the stage"),
    ("stop_contact", False, "touched no end stop"), ("lost_setpoints", 3.0, "3"), ("peak_current", 6.0, "6 A"),
    ("constant", 13.944, "13.94"), ("cogging_force", 4.7, "4.7 N"), ("estimator_deviation", 0.1 / 3.0, "3.33 %")])
def test_values_are_printed_in_the_units_of_the_thesis(name: str, value: float | bool, text: str) -> None:
    assert (METRICS | PROCEDURE_VALUES)[name].printed(value) == text


BOUND = {"figure": "4.27", "metric": "highest", "column": "plant.h.encoder", "unit": "mm", "target": [60, 80]}
FORCE_BOUND = {"figure": "4.11", "value": "cogging_force", "target": ["4 N", 4.5]}


def bound(**table: Any) -> Claim:
    """Bound by the axis of a figure, which has no words of its own."""
    return (ProcedureClaim if "value" in table else RunClaim).model_validate(table)


@pytest.mark.parametrize(("table", "target", "criterion"), [
    (BOUND, (0.06, 0.08), "highest encoder reading of h in 60 … 80 mm"),
    ({**BOUND, "metric": "lowest", "target": [-4, -2], "together_with": ["slow"]}, (-0.004, -0.002),
     "lowest encoder reading of h, also of slow in -4 … -2 mm"),
    ({"figure": "4.20", "metric": "largest", "columns": ["plant.motor.i_a", "plant.motor.i_b"], "unit": "A",
      "target": [2, 4]}, (2.0, 4.0), "largest i_a of motor, i_b of motor in 2 … 4 A"),
    (FORCE_BOUND, (4.0, 4.5), "cogging force in 4 … 4.5 N")])
def test_a_bound_says_where_the_data_of_a_figure_end(table: dict[str, Any], target: tuple[float, float],
                                                     criterion: str) -> None:
    made = bound(**table)
    assert (made.target, made.criterion) == (target, criterion)
    assert (made.source, made.relation) == (f"axis of Fig. {table['figure']}", "in")


@pytest.mark.parametrize(("change", "words"), [
    ({"target": 60}, ["target", "two limits, the lower one first"]),
    ({"target": [80, 60]}, ["target", "the lower limit first"]),
    ({"target": [60, 80, 100]}, ["target", "two limits"]),
    ({"target": ["60 A", 80]}, ["target", "60 A", "in mm"]),
    ({"unit": None}, ["'unit'", "required for the metric highest in"]),
    ({"column": None}, ["'columns'", "required for the metric highest in"]),
    ({"relation": "<"}, ["target", "[60, 80]"]),
    ({"relation": "<", "target": 60}, ["'relation'", "expected in for"]),
    ({"axis": "h"}, ["'axes'", "no meaning"]),
    ({"digits": 2}, ["'digits'", "no meaning"]),
    ({"columns": ["a"]}, ["'column'", "got both"])])
def test_rules_of_bounds(change: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValidationError) as caught:
        bound(**{key: value for key, value in {**BOUND, **change}.items() if value is not None})
    message = str(caught.value.errors()[0])
    assert all(word in message for word in words), message


def test_words_have_no_range_and_other_quantities_no_unit_or_together() -> None:
    assert "expected < or > or about" in refusal(**{**FORCE, "relation": "in", "target": [1, 2]})
    assert "has no meaning for the" in refusal(**{**FORCE, "unit": "N"})
    assert "has no meaning for the" in refusal(**{**OVERSHOOT, "together_with": ["slow"]})
    assert "has no meaning for the bound of a figure" in refusal(
        figure="4.27", metric="overshoot", relation="in", than="fast")
