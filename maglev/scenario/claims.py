"""Claims of the thesis about a run or about a procedure, as a scenario file states them: one grammar for both."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import AfterValidator, Field, StrictBool, ValidationInfo, field_validator, model_validator

import maglev.scenario.quantities as quantities
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.errors import QuantityError, similar
from maglev.files.units import parse_quantity, read_quantity, unit_of
from maglev.scenario.quantities import MeasuredQuantity, in_words, place_words, printed
from maglev.scenario.toml_table import Metres, Seconds, Table, ValueKind, key_refused

OF_ANGLES = ("rad", "rad.s")   # SI units of claims about rotations

# Statement of a claim in words: a printed number, more or less of something than elsewhere, a limit that is kept, or
# whether the stage stays in the air. They are counted separately, in this order and under these names.
ClaimKind = Literal["number", "ordering", "specification", "survival"]
CLAIM_KINDS: dict[ClaimKind, str] = {"number": "printed numbers", "ordering": "orderings",
                                     "specification": "specifications", "survival": "survival"}

SIGNIFICANTLY = 1.1   # how many times as much is "significantly" more: assumed, and one factor for every claim

ConstantName = Annotated[str, AfterValidator(lambda name: known_constant(name))]
GapRange = Annotated[tuple[Metres, Metres], AfterValidator(lambda gaps: ascending(gaps))]


def known_constant(name: str) -> str:
    """Refuse a constant that no stage has."""
    known = sorted({constant.name for stage in PACKAGED_STAGES.values() for constant in stage.constants})
    if name not in known:
        raise ValueError(f"expected one of {', '.join(known)}")
    return name


def ascending(gaps: tuple[float, float]) -> tuple[float, float]:
    """Refuse a range of air gaps that runs backwards."""
    if gaps[0] > gaps[1]:
        raise ValueError("expected the smaller air gap first")
    return gaps


class Claim(Table):
    """The keys that all claims share: words, source, and a relation between a measured and a claimed value.

    "<" and ">" compare with the target, or with `factor` times the value measured elsewhere. "is" compares a yes-or-no
    quantity. "in" requires the measured value to lie in the range of a `figure`: between the two ticks at the ends of
    its axis.
    """

    NOUN: ClassVar[str]                               # what a file calls the quantity
    KNOWN: ClassVar[Mapping[str, MeasuredQuantity]]   # the quantities that there are, by name
    PICKS: ClassVar[tuple[str, ...]]                  # keys that say which values of a quantity count

    text: str = Field(description="sentence of the claim")
    source: str = Field(description="place of the sentence, such as a page")
    figure: str | None = Field(default=None, description="number of a figure: the claim is the range of its axis, "
                                                         "without text and source")
    quantity: str | None = None
    unit: str | None = Field(default=None, description="unit of a target that is a plain number, if the metric has no "
                                                       "unit")
    relation: Literal["<", ">", "is", "about", "in"] | None = Field(
        default=None, description="relation of the measured value to the target; about: within 5 %")
    target: StrictBool | Annotated[float, ValueKind("quantity")] | tuple[float, float] | None = Field(
        default=None, description="value to compare with; for a figure the first or last two ticks")
    digits: int | None = Field(default=None, ge=1, description="significant digits in the source, which give its "
                                                               "weight in an estimation")
    factor: float = Field(default=1.0, gt=0.0, description="factor of the value of `than`, or \"significantly\" for "
                                                           "1.1, or \"not significantly\"")
    over: Literal["all", "any", "mean", "median"] = Field(
        default="all", description="which of several values decides: the worst (all), the best (any), the mean, or "
                                   "the median")
    axes: list[str] | None = Field(default=None, description="axes of the claim, or `axis` for one; otherwise all")
    own: StrictBool = False           # of a file that is not the package's: it is no claim of the thesis
    assumed: StrictBool = Field(default=False, description="true if target or factor come from this project, not from "
                                                           "the source")
    stated_kind: ClaimKind | None = Field(
        default=None, alias="kind", description="kind of the claim; otherwise a number with the relation about, an "
                                                "ordering with `than`, survival for true or false, or else a "
                                                "specification")
    chose: str | None = Field(default=None, description="parameter that was chosen to fit the claim or its figure, "
                                                        "so that the claim is not independent")
    given: str | None = Field(default=None, description="value that the plant got from the thesis and that decides "
                                                        "the claim: it tests the method, not the thesis")
    reason: str | None = Field(default=None, description="why the claim does not reproduce")
    because: Literal["friction"] | None = Field(default=None, description="assumed effect that reason or remark name: "
                                                                          "the report repeats the run without it")
    remark: str | None = Field(default=None, description="remark for the reader, whatever the verdict")
    not_testable: str | None = Field(default=None, description="why the claim cannot be tested")

    @model_validator(mode="before")
    @classmethod
    def written_out(cls, table: Any) -> Any:
        """Write out the short forms of files: words for a factor, bounds of a figure, single names."""
        if not isinstance(table, dict):
            return table
        table = dict(table)
        words = {"significantly": {">": SIGNIFICANTLY, "<": 1.0 / SIGNIFICANTLY},
                 "not significantly": {">": 1.0 / SIGNIFICANTLY, "<": SIGNIFICANTLY}}
        if table.get("factor") in tuple(words):
            by_relation = words[table["factor"]]
            if table.get("relation") not in by_relation:
                raise key_refused("factor", table["factor"], "expected the relation < or > with it")
            table |= {"factor": by_relation[table["relation"]], "assumed": True}
        if "figure" in table:
            table = {"text": "The data end between these ticks of the axis",
                     "source": f"axis of Fig. {table['figure']}", "relation": "in", **table}
        for one, several in (("axis", "axes"), ("motor", "motors"), ("column", "columns")):
            if one in table and several in cls.model_fields:
                if several in table:
                    raise key_refused(one, table[one], f"expected {one} or {several}, got both")
                table[several] = [table.pop(one)]
        return table

    @field_validator("quantity", mode="before")
    @classmethod
    def known_quantity(cls, name: Any) -> Any:
        known = [*cls.KNOWN]
        if name is not None and name not in known:
            names = ", ".join(map(repr, known[:-1]))
            raise ValueError(f"expected {names} or {known[-1]!r}{similar(name, known)}")
        return name

    @field_validator("target", mode="before")
    @classmethod
    def target_to_si(cls, value: Any, info: ValidationInfo) -> float | bool | tuple[float, float]:
        quantity = info.data.get("quantity")
        if quantity is None:
            raise ValueError(f"has no meaning without a {cls.NOUN}")
        if not cls.KNOWN[quantity].yes_no:
            own = cls.KNOWN[quantity].unit
            unit = (info.data.get("unit") if own in (None, *quantities.OF_LENGTHS) else None) or own or "1"
            if info.data.get("relation") != "in":
                return parse_quantity(value, unit)
            if not isinstance(value, list | tuple) or len(value) != 2:
                raise ValueError("expected two limits, the lower one first")
            low, high = (parse_quantity(limit, unit) for limit in value)
            if not low < high:
                raise ValueError("expected the lower limit first")
            return low, high
        if not isinstance(value, bool):
            raise ValueError(f"expected true or false for the {cls.NOUN} {quantity}")
        return value

    @model_validator(mode="after")
    def complete(self) -> Self:
        """Refuse a claim that lacks something its quantity needs, or has something that means nothing to it."""
        if self.quantity is None and self.not_testable is None:
            raise key_refused(self.NOUN, None, f"expected a {self.NOUN}, or not_testable with the reason")
        if self.quantity is not None and self.not_testable is not None:
            raise key_refused("not_testable", self.not_testable, f"expected a {self.NOUN} or not_testable, got both")
        needed, optional = self.keys()
        kind = "a claim that is not testable"
        if self.quantity is not None:
            words = (self.NOUN, self.quantity, self.relation, "with than" if self.comparative else None)
            kind = " ".join(filter(None, ("the", *words)))
        for key in ("relation", "target", "digits", "unit", *self.PICKS):
            value = getattr(self, key)
            if value is None and key in needed:
                raise key_refused(key, None, f"required for {kind}")
            if value is not None and key not in needed | optional:
                raise key_refused(key, value, f"has no meaning for {kind}")
        if self.quantity is not None and self.relation not in self.relations:
            raise key_refused("relation", self.relation, f"expected {' or '.join(self.relations)} for {kind}")
        if self.figure is not None and self.comparative:
            raise key_refused("than", self.elsewhere, "has no meaning for the bound of a figure")
        if self.comparative and (self.measured is None or self.measured.yes_no):
            raise key_refused("than", self.elsewhere, f"expected a {self.NOUN} that is a number")
        if self.because is not None and self.reason is None and self.remark is None:
            raise key_refused("because", self.because, "expected a reason, or a remark, that says why")
        if self.factor != 1.0 and not self.comparative:
            raise key_refused("factor", self.factor, "has no meaning without than")
        if self.figure is not None and self.stated_kind is not None:
            raise key_refused("kind", self.stated_kind, "has no meaning for the bound of a figure")
        return self

    def keys(self) -> tuple[set[str], set[str]]:
        """Return the keys that a claim about this quantity must have, and those that it may have."""
        if self.measured is None:
            return set(), set()
        needed = {"relation"} if self.comparative else {"relation", "target"}
        if self.measured.needs is not None:
            needed.add(self.measured.needs)
        if self.measured.on == "column":
            needed.add("unit")
        return needed, {*quantities.PICKED_BY[self.measured.on], *(["digits"] if self.relation == "about" else []),
                        *(["unit"] if self.of_one_unit else [])}

    @property
    def relations(self) -> tuple[str, ...]:
        if self.measured is not None and self.measured.yes_no:
            return ("is",)
        if self.figure is not None:
            return ("in",)
        return ("<", ">") if self.comparative else ("<", ">", "about")

    @property
    def measured(self) -> MeasuredQuantity | None:
        """Return the quantity that the claim is about; None if it is not testable."""
        return None if self.quantity is None else self.KNOWN[self.quantity]

    @property
    def kind(self) -> ClaimKind:
        """Return the kind of statement, which is a number for a bound of a figure."""
        if self.stated_kind is not None:
            return self.stated_kind
        if self.comparative:
            return "ordering"
        if self.measured is not None and self.measured.yes_no:
            return "survival"
        return "number" if self.relation in ("about", "in") else "specification"

    @property
    def cited(self) -> str:
        """Return the place of the claim in the thesis, with a remark if the threshold is ours."""
        ours = "the factor is ours" if self.comparative else "the limit is ours"
        return f"{self.source}; {ours}" if self.assumed and not self.own else self.source

    @property
    def claims_a_difference(self) -> bool:
        """Return True for a comparison that says "more" or "less"."""
        return self.comparative and (self.factor >= 1.0 if self.relation == ">" else self.factor <= 1.0)

    @property
    def axis_unit(self) -> str:
        """SI unit of the axes that the claim is about, if it is about lengths or angles: m, or rad of rotations."""
        return "rad" if self.unit is not None and unit_of(self.unit).si in OF_ANGLES else "m"

    @property
    def of_one_unit(self) -> bool:
        """Return True if the claim cannot be about axes of different units together."""
        return self.measured is not None and self.measured.of_axes and (
            self.measured.unit in quantities.OF_LENGTHS or self.measured.needs == "band")

    @property
    def name(self) -> str:
        """The quantity in words, such as "mean tracking error"."""
        return self.measured.words if self.measured else ""

    @property
    def comparative(self) -> bool:
        return self.elsewhere is not None

    @property
    @abstractmethod
    def subject(self) -> str:
        """Return the measured quantity in words, such as "settling time to 0.1 mm"."""

    @property
    @abstractmethod
    def elsewhere(self) -> str | None:
        """Return where the other value of a comparative claim is measured, in words; None if the claim has a target."""

    def printed(self, value: float | bool | None) -> str:
        """Print a value of the claim's quantity with its unit; empty if there is none."""
        if value is None or self.measured is None:
            return ""
        if self.unit and self.measured.unit is None:
            return printed(value, "", quantities.PRINTED_UNITS.get(self.unit, self.unit))
        return self.measured.printed(value, self.axis_unit)

    @property
    def criterion(self) -> str:
        """Return the quantity and its claimed value, such as "settling time to 0.1 mm < 5 s"; empty if not testable."""
        if self.quantity is None:
            return ""
        if isinstance(self.target, tuple):
            low, high = map(self.printed, self.target)
            return f"{self.subject} in {low.removesuffix(high[high.find(' '):])} … {high}"
        if self.relation == "is":
            return self.printed(self.target)
        if not self.comparative:
            return f"{self.subject} {self.relation} {self.printed(self.target)}"
        return f"{self.subject} {self.relation} {'' if self.factor == 1.0 else f'{self.factor:.3g} × '}{self.elsewhere}"


class RunClaim(Claim):
    """One claim about a run: that a metric has a relation to a target, or to the same metric elsewhere.

    A claim with `than`, the name of another run, or `than_axis`, another axis, compares with the value measured there.
    The values are of the same axis (or of that other one) at the same step, or of the same motor. The extreme of
    `columns`, such as "plant.v.position", is that of this run `together_with` others that the figure draws over the
    same axis.
    """

    NOUN = "metric"
    KNOWN = quantities.METRICS
    PICKS = ("band", "axes", "motors", "columns", "together_with", "event")

    PLACE = "[[claims]]"

    quantity: str | None = Field(default=None, alias="metric", description="metric of the claim")
    motors: list[str] | None = Field(default=None, description="motors of the claim, or `motor` for one; otherwise all")
    event: str | None = Field(default=None, description="name of the event; otherwise all events")
    band: Annotated[float, ValueKind("length or angle")] | None = Field(
        default=None, description="band of a settling time, one of `metrics.bands` or `metrics.tilt_bands`")
    columns: list[str] | None = Field(default=None, min_length=1, description="recorded columns `fmu.variable` of "
                                                                              "lowest, highest, largest, or `column` "
                                                                              "for one")
    together_with: list[str] | None = Field(default=None, description="other runs over the same axis of a figure")
    than: str | None = Field(default=None, description="another run, whose value is the target")
    than_axis: str | None = Field(default=None, description="another axis, whose value is the target")

    @model_validator(mode="before")
    @classmethod
    def unit_of_tilts(cls, table: Any) -> Any:
        """A claim about axes with a target or a band in rad is about rotations: it is in mrad without `unit`."""
        if not isinstance(table, dict) or "unit" in table:
            return table
        measured = quantities.METRICS.get(str(table.get("metric")))
        if measured is None or not measured.of_axes:
            return table
        for value in (table.get("target"), table.get("band")):
            if isinstance(value, str):
                try:
                    unit = unit_of(str(read_quantity(value).unit)).si
                    if unit in OF_ANGLES:
                        return {**table, "unit": quantities.PRINTED_UNITS["rad.s" if measured.unit == "m.s" else "rad"]}
                except QuantityError:
                    pass   # refused with its key when the field itself is read
        return table

    @field_validator("band", mode="before")
    @classmethod
    def band_to_si(cls, value: Any, info: ValidationInfo) -> float:
        """Convert to SI, of a claim in rad from rad."""
        unit = info.data.get("unit")
        return parse_quantity(value, "rad" if unit is not None and unit_of(unit).si in OF_ANGLES else "m")

    @model_validator(mode="after")
    def axes_to_compare(self) -> Self:
        """Refuse another axis for a metric that belongs to none."""
        if self.than_axis is not None and self.measured is not None and not self.measured.of_axes:
            raise key_refused("than_axis", self.than_axis, f"has no meaning for the metric {self.quantity}")
        return self

    @property
    def other_runs(self) -> list[str]:
        """Names of the other runs that the claim cannot be judged without."""
        return [*([] if self.than is None else [self.than]), *(self.together_with or ())]

    @property
    def subject(self) -> str:
        """Return the quantity in words, such as "settling time to 0.1 mm of x", or "peak deviation of x after push"."""
        if self.columns is not None:
            others = [f"also of {run}" for run in self.together_with or ()]
            return f"{self.name} " + ", ".join([*map(in_words, self.columns), *others])
        name = self.name if self.band is None else f"{self.name} to {printed(self.band, self.axis_unit)}"
        name = f"{self.over} {name}" if self.over in ("mean", "median") else name
        name = " of ".join(filter(None, (name, ", ".join(self.axes or self.motors or ()))))
        return name if self.event is None else f"{name} after {self.event}"

    @property
    def elsewhere(self) -> str | None:
        """Axis and run that the claim compares with, such as "that of x of 3dof-tracking"; None if it has a target."""
        names = [name for name in (self.than_axis, self.than) if name is not None]
        return " of ".join(["that", *names]) if names else None


class Elsewhere(Table):
    """The place where a comparative claim about a procedure finds its other value: another ε, or other air gaps."""

    PLACE = "than of [[procedure.claims]]"

    epsilon: Seconds | None = Field(default=None, description="another ε of the estimator")
    gaps: GapRange | None = Field(default=None, description="other air gaps")

    @model_validator(mode="after")
    def different(self) -> "Elsewhere":
        if self.epsilon is None and self.gaps is None:
            raise key_refused("than", None, "expected epsilon, gaps or both in it")
        return self


class ProcedureClaim(Claim):
    """One claim about a procedure: that a value, or its mean, has a relation to a target, or to the same elsewhere.

    It uses the values of that name that have the claim's constant, ε, axes and range of air gaps.
    """

    NOUN = "value"
    KNOWN = quantities.PROCEDURE_VALUES
    PICKS = ("constant", "epsilon", "axes", "gaps")

    PLACE = "[[procedure.claims]]"

    quantity: str | None = Field(default=None, alias="value", description="result of the procedure")
    constant: ConstantName | None = Field(default=None, description="name of the constant")
    epsilon: Seconds | None = Field(default=None, description="ε of the estimator")
    gaps: GapRange | None = Field(default=None, description="range of air gaps, the smaller one first")
    than: Elsewhere | None = Field(default=None, description="other ε or air gaps, whose mean is the target")

    @property
    def subject(self) -> str:
        """Return the quantity in words, such as "mean cogging force, gap 10 to 15 mm"."""
        average = "mean " if self.comparative else f"{self.over} " if self.over in ("mean", "median") else ""
        name = "" if self.quantity == "constant" else self.name
        axes = "" if self.axes is None else f"of {', '.join(self.axes)}"
        return average + " ".join(filter(None, (name, self.constant, axes))) + place_words(self.epsilon, self.gaps)

    @property
    def elsewhere(self) -> str | None:
        """Return the place of the other value, such as "that, ε = 0.01 s"; None with a target."""
        return None if self.than is None else f"that{place_words(self.than.epsilon, self.than.gaps)}"
