"""What a scenario file says about the procedure that its runs belong to, and the claims about the procedure."""

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, field_validator, model_validator

from maglev.errors import nearest
from maglev.schema.claims import Statement, listed
from maglev.schema.toml_table import Metres, Seconds, Table, key_refused
from maglev.units import parse_quantity, to_unit

Kind = Literal["parabolas", "equilibrium", "cogging", "identification", "forgetting"]

# Runs that a kind needs, by the part that they play.
PARTS: dict[str, tuple[str, ...]] = {
    "parabolas": (),
    "equilibrium": ("currents", "excitation"),
    "cogging": ("offset", "excitation", "currents"),
    "identification": ("rig", "model", "currents", "parabolas"),
    "forgetting": ("jump",),
}

# Figures that a kind draws: what `figures` may number.
FIGURES: dict[str, tuple[str, ...]] = {
    "parabolas": ("motion h", "motion x", "motion z", "thrust", "simultaneous"),
    "equilibrium": ("currents",),
    "cogging": ("force", "currents"),
    "identification": ("thrust", "currents"),
    "forgetting": (),
}
PRINTED_AT = {3: (0.001, 0.01, 0.05), 1: (0.01,)}   # s, ε of the thesis's values by their number

# Values that a procedure finds, with their units; None: the unit depends on the constant, and the number is plain.
VALUES: dict[str, str | None] = {
    "constant": None,                  # estimate of a constant
    "average_constant": None,          # mean over the air gaps
    "thrust": None,                    # L at an air gap, by parabola fit, m/(s² A)
    "estimator_deviation": "1",        # of L by the estimator from L by parabola fit, share
    "simultaneous_deviation": "1",     # of L with both axes moving from L with one, share
    "equilibrium_deviation": "A",      # of the predicted equilibrium current from the measured one
    "cogging_force": "N",              # peak
    "position_deviation": "1",         # RMS of model - rig over RMS of the rig's motion, share
    "speed_deviation": "1",
}
PRINTED = {"1": "%", "A": "A", "N": "N"}

ValueName = Literal["constant", "average_constant", "thrust", "estimator_deviation", "simultaneous_deviation",
                    "equilibrium_deviation", "cogging_force", "position_deviation", "speed_deviation"]
ConstantName = Literal["C1", "C2", "C3", "C4", "C5"]
GapRange = Annotated[tuple[Metres, Metres], AfterValidator(lambda gaps: ascending(gaps))]


def ascending(gaps: tuple[float, float]) -> tuple[float, float]:
    """Refuse a range of air gaps that runs backwards."""
    if gaps[0] > gaps[1]:
        raise ValueError("expected the smaller air gap first")
    return gaps


class Elsewhere(Table):
    """What is different where a comparative claim looks for the same value."""

    epsilon: Seconds | None = None
    gaps: GapRange | None = None

    @model_validator(mode="after")
    def different(self) -> "Elsewhere":
        """Refuse a comparison with itself."""
        if self.epsilon is None and self.gaps is None:
            raise key_refused("than", None, "expected epsilon, gaps or both in it")
        return self


class ProcedureClaim(Statement):
    """One claim about a procedure: that a value, or its mean, has a relation to a target, or to the same elsewhere.

    Of the values of that name those count that fit: of the constant, at ε, of the axes, in the range of air gaps.
    With `than` the mean is compared with `factor` times the mean of those that fit when what `than` gives is
    changed.
    """

    value: ValueName | None = None
    constant: ConstantName | None = None
    epsilon: Seconds | None = None
    axes: list[str] | None = None
    gaps: GapRange | None = None
    target: float | None = None
    than: Elsewhere | None = None

    @model_validator(mode="before")
    @classmethod
    def single_names(cls, table: Any) -> Any:
        """Accept `axis` for one name."""
        return listed(table, axis="axes")

    @field_validator("target", mode="before")
    @classmethod
    def target_to_si(cls, value: Any, info: Any) -> float:
        """Convert to SI."""
        return parse_quantity(value, VALUES.get(str(info.data.get("value"))) or "1")

    @model_validator(mode="after")
    def complete(self) -> "ProcedureClaim":
        """Refuse a claim that lacks something, or has something that means nothing to it."""
        if (self.value is None) == (self.not_testable is None):
            raise key_refused("value", self.value, "expected a value, or not_testable with the reason")
        if self.value is None:
            return self
        if (self.value in ("constant", "average_constant")) != (self.constant is not None):
            raise key_refused("constant", self.constant, "expected it with constant and average_constant only")
        expected = ("<", ">") if self.comparative else ("<", ">", "about")
        if self.relation not in expected:
            raise key_refused("relation", self.relation, f"expected {' or '.join(expected)}")
        if self.comparative == (self.target is not None):
            raise key_refused("target", self.target, "expected a target or than")
        if (self.relation == "about") != (self.digits is not None):
            raise key_refused("digits", self.digits, "expected it with about only")
        if self.factor != 1.0 and not self.comparative:
            raise key_refused("factor", self.factor, "has no meaning without than")
        return self

    @property
    def comparative(self) -> bool:
        """Whether the claim compares two measured values."""
        return self.than is not None

    def printed(self, value: float | bool | None) -> str:
        """Print a value with its unit."""
        if value is None:
            return ""
        unit = VALUES[str(self.value)]
        return f"{value:.4g}" if unit is None else f"{to_unit(float(value), PRINTED[unit]):.3g} {PRINTED[unit]}"

    @property
    def criterion(self) -> str:
        """What is measured and what it should be, such as "cogging force, gap 10 to 15 mm > 2 N"."""
        if self.value is None:
            return ""
        average = "mean " if self.over == "mean" or self.comparative else ""
        name = str(self.constant) if self.value == "constant" else str(self.value).replace("_", " ")
        name += f" {self.constant}" if self.value == "average_constant" else ""
        subject = average + name + self.place(self.epsilon, self.gaps)
        if self.than is None:
            return f"{subject} {self.relation} {self.printed(self.target)}"
        factor = "" if self.factor == 1.0 else f"{self.factor:g} × "
        return f"{subject} {self.relation} {factor}that{self.place(self.than.epsilon, self.than.gaps)}"

    @staticmethod
    def place(epsilon: float | None, gaps: GapRange | None) -> str:
        """Words for where a value is looked for."""
        words = "" if epsilon is None else f", ε = {epsilon:g} s"
        if gaps is not None:
            low, high = (to_unit(gap, "mm") for gap in gaps)
            words += f", gap {low:g} mm" if low == high else f", gap {low:g} to {high:g} mm"
        return words


class ProcedureSettings(Table):
    """The procedure of a scenario file.

    Attributes
    ----------
    kind : str
        How its runs are evaluated; see the modules of this package.
    name : str
        Under which its findings are listed, such as "2dof-procedure-1".
    title : str
    runs : dict of str to str
        Runs by the part that they play, see `PARTS`; for the parabolas the name of their procedure.
    figures : dict of str to str
        Numbers of the figures of the thesis by what they show.
    table : str
        Number of the table of the thesis with the constants.
    printed : dict of str to list of float
        Constants of the thesis at ε = 0.001, 0.01 and 0.05; a single value is at 0.01.
    gaps : (float, float), optional
        Range of air gaps that the thesis's figures cover, m.
    claims : list of ProcedureClaim
    """

    kind: Kind
    name: Annotated[str, Field(pattern=r"^\w[\w.+-]*$")]   # results are named after it
    title: str
    runs: dict[str, str] = {}
    figures: dict[str, str] = {}
    table: str = ""
    printed: dict[ConstantName, Annotated[list[float], Field(min_length=1, max_length=3)]] = {}
    gaps: GapRange | None = None
    claims: list[ProcedureClaim] = []

    @model_validator(mode="after")
    def complete(self) -> "ProcedureSettings":
        """Refuse runs in parts that the kind does not have, and parts without a run."""
        parts = PARTS[self.kind]
        for part in self.runs:
            if part not in parts:
                raise key_refused(part, self.runs[part], f"not a part of {self.kind}, expected {' or '.join(parts)}",
                                  "runs")
        for shown in self.figures:
            if shown not in FIGURES[self.kind]:
                raise key_refused(shown, self.figures[shown], f"not a figure of {self.kind}, nearest is "
                                  f"{nearest(shown, FIGURES[self.kind])}", "figures")
        for constant, values in self.printed.items():
            if len(values) not in PRINTED_AT:
                raise key_refused(constant, values, "expected three values, or one", "printed")
        missing = [part for part in parts if part not in self.runs]
        if missing:
            raise key_refused("runs", self.runs, f"expected a run for {', '.join(missing)}")
        if self.kind == "cogging" and self.gaps is None:
            raise key_refused("gaps", None, "expected the range of air gaps for the force")
        return self

    def printed_at(self, epsilon: float) -> dict[str, float]:
        """Constants of the thesis at an ε (s), by name; empty if it has none there."""
        return {constant: value for constant, values in self.printed.items()
                for at, value in zip(PRINTED_AT[len(values)], values, strict=True) if math.isclose(at, epsilon)}
