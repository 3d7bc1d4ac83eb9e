"""Verdicts on the claims about a procedure: which of its values count, and what they are compared with."""

from typing import Any

import pytest

from maglev.runs.procedure_outcome import Outcome, ProcedureValue
from maglev.runs.procedures import judge_procedure
from maglev.runs.verdicts import ClaimResult
from maglev.scenario.claims import ProcedureClaim
from maglev.scenario.procedure import ProcedureSettings

VALUES = (
    ProcedureValue("cogging_force", 4.7, gap=0.010), ProcedureValue("cogging_force", 3.0, gap=0.0125),
    ProcedureValue("cogging_force", 1.0, gap=0.015),
    ProcedureValue("estimator_deviation", 0.01, axis="x", epsilon=0.01, gap=0.010),
    ProcedureValue("estimator_deviation", 0.03, axis="x", epsilon=0.01, gap=0.015),
    ProcedureValue("estimator_deviation", 0.06, axis="z", epsilon=0.01, gap=0.015),
    ProcedureValue("estimator_deviation", 0.20, axis="x", epsilon=0.05, gap=0.010),
    ProcedureValue("estimator_deviation", 0.02, axis="z", epsilon=0.05, gap=0.015),
    ProcedureValue("constant", 13.9, constant="C1", epsilon=0.01),
    ProcedureValue("constant", 15.0, constant="C1", epsilon=0.05),
    ProcedureValue("constant", 790.0, constant="C2", epsilon=0.01),
    ProcedureValue("position_deviation", 0.02, axis="v"), ProcedureValue("position_deviation", 0.08, axis="h"))


def judged(values: tuple[ProcedureValue, ...] = VALUES, **table: Any) -> ClaimResult:
    claim = ProcedureClaim.model_validate({"text": "a claim", "source": "p. 1", **table})
    settings = ProcedureSettings(kind="parabolas", name="mine", title="Mine", claims=[claim])
    (result,) = judge_procedure(Outcome(settings, (), values))
    return result


FORCE: dict[str, Any] = {"value": "cogging_force"}
DEVIATION: dict[str, Any] = {"value": "estimator_deviation"}
CONSTANT: dict[str, Any] = {"value": "constant", "relation": "about", "digits": 3}


@pytest.mark.parametrize(("table", "verdict", "measured"), [
    ({**FORCE, "relation": "<", "target": "5 N"}, "reproduced", 4.7),
    ({**FORCE, "relation": "<", "target": "4.5 N"}, "within 10 %", 4.7),
    ({**FORCE, "relation": "<", "target": "4 N"}, "not reproduced", 4.7),
    ({**FORCE, "relation": ">", "target": "0.9 N"}, "reproduced", 1.0),
    ({**FORCE, "relation": "<", "target": "2 N", "over": "any"}, "reproduced", 1.0),
    ({**FORCE, "relation": "<", "target": "3 N", "over": "mean"}, "reproduced", 2.9),
    ({**FORCE, "relation": ">", "target": "2 N", "gaps": ["10 mm", "12.5 mm"]}, "reproduced", 3.0),
    ({**FORCE, "relation": "about", "target": "1 N", "digits": 1, "gaps": ["15 mm", "15 mm"]}, "reproduced", 1.0),
    ({**FORCE, "relation": "<", "target": "1 N", "gaps": ["16 mm", "20 mm"]}, "not run", None),
    ({**DEVIATION, "epsilon": "10 ms", "relation": "<", "target": "5 %"}, "not reproduced", 0.06),
    ({**DEVIATION, "epsilon": "10 ms", "axis": "x", "relation": "<", "target": "5 %"}, "reproduced", 0.03),
    ({**DEVIATION, "axes": ["x", "z"], "relation": "<", "target": "25 %"}, "reproduced", 0.20),
    ({**DEVIATION, "epsilon": "20 ms", "relation": "<", "target": "5 %"}, "not run", None),
    ({**DEVIATION, "axis": "y", "relation": "<", "target": "5 %"}, "not run", None),
    ({**CONSTANT, "constant": "C1", "epsilon": 0.01, "target": 14.2}, "reproduced", 13.9),
    ({**CONSTANT, "constant": "C1", "epsilon": 0.01, "target": 15.0}, "within 10 %", 13.9),
    ({**CONSTANT, "constant": "C1", "epsilon": 0.01, "target": 16.0}, "not reproduced", 13.9),
    ({**CONSTANT, "constant": "C2", "target": 790}, "reproduced", 790.0),
    ({**CONSTANT, "constant": "C3", "target": 31}, "not run", None),
    ({"value": "position_deviation", "relation": "<", "target": "10 %"}, "reproduced", 0.08),
    ({"value": "speed_deviation", "relation": "<", "target": "10 %"}, "not run", None),
    ({"not_testable": "no stage"}, "not testable", None)])
def test_claims_with_a_target(table: dict[str, Any], verdict: str, measured: float | None) -> None:
    result = judged(**table)
    assert (result.verdict, result.measured) == (verdict, pytest.approx(measured))
    assert result.against is None


@pytest.mark.parametrize(("table", "verdict", "measured", "against"), [
    # Mean of 0.20 and 0.02 at ε = 0.05 s, of 0.01, 0.03 and 0.06 at 0.01 s.
    ({**DEVIATION, "epsilon": 0.05, "relation": ">", "than": {"epsilon": 0.01}}, "reproduced", 0.11, 0.1 / 3),
    ({**DEVIATION, "epsilon": 0.05, "relation": "<", "than": {"epsilon": 0.01}}, "not reproduced", 0.11, 0.1 / 3),
    ({**DEVIATION, "epsilon": 0.05, "relation": "<", "factor": 3.5, "than": {"epsilon": 0.01}}, "reproduced", 0.11,
     0.1 / 3),
    ({**DEVIATION, "epsilon": 0.05, "relation": "<", "factor": 3.1, "than": {"epsilon": 0.01}}, "within 10 %", 0.11,
     0.1 / 3),
    # What `than` does not change stays: axes and ε, or axes and air gaps.
    ({**DEVIATION, "epsilon": 0.01, "axis": "z", "relation": ">", "than": {"gaps": ["14 mm", "16 mm"]}},
     "no difference", 0.06, 0.06),
    ({**DEVIATION, "epsilon": 0.05, "axis": "x", "gaps": ["10 mm", "10 mm"], "relation": ">",
      "than": {"epsilon": 0.01}}, "reproduced", 0.2, 0.01),
    ({**DEVIATION, "epsilon": 0.01, "axis": "x", "gaps": ["10 mm", "10 mm"], "relation": "<",
      "than": {"gaps": ["15 mm", "15 mm"]}}, "reproduced", 0.01, 0.03),
    ({**FORCE, "gaps": ["10 mm", "14 mm"], "relation": ">", "than": {"gaps": ["15 mm", "25 mm"]}}, "reproduced", 3.85,
     1.0),
    ({**FORCE, "gaps": ["10 mm", "14 mm"], "relation": ">", "than": {"gaps": ["20 mm", "25 mm"]}}, "not run", None,
     None),
    ({**DEVIATION, "epsilon": 0.05, "relation": ">", "than": {"epsilon": 0.02}}, "not run", None, None)])
def test_claims_that_compare_means(table: dict[str, Any], verdict: str, measured: float | None,
                                   against: float | None) -> None:
    result = judged(**table)
    assert (result.verdict, result.measured, result.against) == (verdict, pytest.approx(measured),
                                                                 pytest.approx(against))


def test_air_gaps_of_a_range_are_compared_as_written() -> None:
    """Means over a run, and ranges of decimal numbers, are never exact in binary."""
    third = ProcedureValue("cogging_force", 1.0, gap=0.1 * 0.15 + 1e-12)
    for gaps in (["15 mm", "20 mm"], ["10 mm", "15 mm"], ["15 mm", "15 mm"]):
        assert judged((third,), **FORCE, relation="<", target="2 N", gaps=gaps).verdict == "reproduced"
    apart = ProcedureValue("cogging_force", 1.0, gap=0.01502)
    assert judged((apart,), **FORCE, relation="<", target="2 N", gaps=["10 mm", "15 mm"]).verdict == "not run"


def test_without_values_nothing_was_run() -> None:
    for table in ({**FORCE, "relation": "<", "target": "2 N"},
                  {**DEVIATION, "relation": "<", "than": {"epsilon": 0.01}}):
        assert judged((), **table).verdict == "not run"


def test_verdicts_are_told_in_the_units_of_the_thesis() -> None:
    assert judged(**FORCE, relation="<", target="5 N").measured_text == "4.7 N"
    assert judged(**DEVIATION, epsilon=0.05, relation=">", than={"epsilon": 0.01}).measured_text == (
        "11 % against 3.33 %")
    assert judged(**CONSTANT, constant="C1", epsilon=0.01, target=14.2).measured_text == "13.9"
