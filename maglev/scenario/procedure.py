"""The table of a scenario file about the procedure that its runs belong to."""

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from maglev.files.errors import nearest
from maglev.scenario.claims import ConstantName, GapRange, ProcedureClaim
from maglev.scenario.toml_table import Table, key_refused

Kind = Literal["parabolas", "equilibrium", "cogging", "identification", "forgetting"]

# Runs that a kind needs, by the part that they play.
PARTS: dict[str, tuple[str, ...]] = {
    "parabolas": (),
    "equilibrium": ("currents", "excitation"),
    "cogging": ("offset", "excitation", "currents"),
    "identification": ("stage", "model", "currents", "parabolas"),
    "forgetting": ("jump",),
}

# Figures that a kind draws, which `figures` may number.
FIGURES: dict[str, tuple[str, ...]] = {
    "parabolas": ("motion h", "motion x", "motion z", "thrust", "simultaneous"),
    "equilibrium": ("currents",),
    "cogging": ("force", "currents"),
    "identification": ("thrust", "currents"),
    "forgetting": (),
}
PRINTED_AT = {3: (0.001, 0.01, 0.05), 1: (0.01,)}   # s, ε of the thesis's values by their number


class ProcedureSettings(Table):
    """The procedure of a scenario file; the parts that its runs play are in `PARTS`."""

    PLACE = "[procedure]"

    kind: Kind = Field(description="evaluation of the runs")
    name: str = Field(pattern=r"^\w[\w.+-]*$", description="name of the results")
    title: str = Field(description="title of a few words")
    runs: dict[str, str] = Field(default={}, description="names of the runs, by their role")
    figures: dict[str, str] = Field(default={}, description="numbers of the thesis's figures, by their content")
    table: str = Field(default="", description="number of the thesis's table with the constants")
    printed: dict[ConstantName, Annotated[list[float], Field(min_length=1, max_length=3)]] = Field(
        default={}, description="constants of the thesis at ε = 1 ms, 10 ms and 50 ms; a single value is at 10 ms")
    gaps: GapRange | None = Field(default=None, description="range of air gaps in the thesis's figures, the smaller "
                                                            "one first")
    claims: list[ProcedureClaim] = Field(default=[], description="claims about the procedure")

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
                raise key_refused(shown, self.figures[shown], f"not a figure of {self.kind}, "
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
        """Return the constants of the thesis at an ε (s), by name; empty if it has none there."""
        return {constant: value for constant, values in self.printed.items()
                for at, value in zip(PRINTED_AT[len(values)], values, strict=True) if math.isclose(at, epsilon)}
