"""Measured and claimed quantities: one table with their names and units, and the format of their values."""

import math
from collections.abc import Iterable
from typing import Literal, NamedTuple

from maglev.files.fmi_units import typeset_unit
from maglev.files.units import known_unit, to_unit, unit_of

# Printed units, by the SI unit, and the units of small values.
PRINTED_UNITS = {"1": "%", "m": "mm", "rad": "mrad", "m/s": "mm/s", "rad/s": "mrad/s", "m.s": "mm.s", "rad.s": "mrad.s"}
SMALL_UNITS = {"mm": "µm", "mrad": "µrad", "s": "ms", "mm.s": "µm.s", "mrad.s": "µrad.s"}
SMALL = 0.1   # of the unit, below which a smaller unit is printed

# Objects on which a quantity is measured, and the keys with which a claim may pick some of its values.
MeasuredOn = Literal["axis", "tracking", "step", "motor", "event", "effort", "column", "run", "procedure"]
PICKED_BY: dict[MeasuredOn, tuple[str, ...]] = {
    "axis": ("axes",), "tracking": ("axes",), "step": ("axes",), "motor": ("motors",), "event": ("axes", "event"),
    "effort": ("motors", "event"), "column": ("together_with",), "run": (), "procedure": ("epsilon", "axes", "gaps")}
OF_LENGTHS = ("m", "m.s")   # units that on a rotation have rad instead of m


def printed(value: float, unit: str, wanted: str | None = None) -> str:
    """Return a finite SI value as text with its unit: the one rule for tables, verdicts and pages.

    Lengths, angles and times are in mm, mrad and s, or in µm, µrad and ms if they are below a tenth of these. Shares
    ("1") are in per cent, all other units are unchanged. A text has three significant digits, and all digits before the
    point of a value above 100. Plain numbers, and values in a `wanted` unit, have four digits.
    """
    if wanted or not unit:
        return f"{to_unit(value, wanted) if wanted else value:.4g} {typeset_unit(wanted or '')}".rstrip()
    shown = PRINTED_UNITS.get(unit, unit)
    if value != 0.0 and abs(to_unit(value, shown)) < SMALL:
        shown = SMALL_UNITS.get(shown, shown)
    number, shown = to_unit(value, shown), typeset_unit(shown)
    return f"{number:.0f} {shown}" if abs(number) >= 100.0 else f"{number:.3g} {shown}"


def common_unit(values: Iterable[float], unit: str) -> str:
    """Return the unit in which all of some SI values of a quantity are printed or drawn: that of the largest of them.
    """
    shown = PRINTED_UNITS.get(unit, unit)
    largest = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
    return SMALL_UNITS.get(shown, shown) if largest > 0.0 and known_unit(shown) and to_unit(largest, shown) < SMALL \
        else shown


def shown_in(values: Iterable[float], unit: str) -> tuple[str, float]:
    """Return that unit as people read it, and its number per SI unit; 1 if the unit is not known here."""
    shown = common_unit(values, unit)
    return typeset_unit(shown), 1.0 / unit_of(shown).factor if known_unit(shown) else 1.0


def metric_text(name: str, value: float, unit: str) -> str:
    """Return a value of a metric as text; its name begins as in the table, such as "settling time to 10 µm of x"."""
    if math.isinf(value):
        return next((metric.infinite for metric in METRICS.values() if name.startswith(metric.words)), "inf")
    return printed(value, unit)


class MeasuredQuantity(NamedTuple):
    """A measured quantity: its objects, its unit, and the keys that a claim about it must have.

    A unit in m is rad on a rotation. The unit of a constant depends on it, and a claim about a column gives its own. An
    "event" is the response of an axis to an event of the scenario, an "effort" that of a motor.
    """

    words: str                 # its name everywhere; a file and Python have an underscore for each space or hyphen
    on: MeasuredOn
    unit: str | None = None    # SI, also of plain numbers as targets, "1" of shares; None: a plain number
    needs: str | None = None   # key without which a claim does not say what it is about
    recorded: str = ""         # what a run must have recorded for it: currents, commands, trip, stop contact
    infinite: str = "inf"      # words for an infinite value
    yes_no: tuple[str, str] | None = None   # words for that it happened and that it did not; None of a number

    @property
    def of_axes(self) -> bool:
        """Return True if each axis of a run has values of its own."""
        return self.on in ("axis", "tracking", "step", "event")

    @property
    def of_motors(self) -> bool:
        """Return True if each motor of a run has values of its own."""
        return self.on in ("motor", "effort")

    def unit_on(self, axis_unit: str) -> str:
        """Return the SI unit on an axis in m or rad; empty for a plain number."""
        return axis_unit + (self.unit or "")[1:] if self.unit in OF_LENGTHS else self.unit or ""

    def printed(self, value: float | bool, axis_unit: str = "m") -> str:
        """Return a value as text with its unit; on an axis in rad its lengths are angles."""
        if self.yes_no:
            return self.yes_no[0] if value else self.yes_no[1]
        if math.isinf(value):
            return self.infinite
        return printed(value, self.unit_on(axis_unit))


def by_name(*quantities: MeasuredQuantity) -> dict[str, MeasuredQuantity]:
    return {quantity.words.replace("-", " ").replace(" ", "_"): quantity for quantity in quantities}


METRICS = by_name(
    MeasuredQuantity("failed", "run", recorded="stop contact", yes_no=("lost the stage", "kept the stage in the air")),
    MeasuredQuantity("ended off", "run", yes_no=("ended off target", "ended on target")),
    MeasuredQuantity("trip time", "run", "s", recorded="trip", infinite="never"),
    MeasuredQuantity("stop contact time", "run", "s", recorded="stop contact", infinite="never"),
    MeasuredQuantity("lost setpoints", "run", recorded="stop contact"),
    MeasuredQuantity("tripped", "run", recorded="trip", yes_no=("tripped", "did not trip")),
    MeasuredQuantity("stop contact", "run", recorded="stop contact",
                     yes_no=("touched an end stop", "touched no end stop")),
    MeasuredQuantity("rms error", "axis", "m"),                # over the whole run
    MeasuredQuantity("end error", "axis", "m"),
    MeasuredQuantity("mean tracking error", "tracking", "m"),
    MeasuredQuantity("peak tracking error", "tracking", "m"),
    MeasuredQuantity("tracking transient", "tracking", "s"),
    MeasuredQuantity("peak current", "motor", "A", recorded="currents"),
    MeasuredQuantity("mean current", "motor", "A", recorded="currents"),
    MeasuredQuantity("peak command", "motor", "A", recorded="commands"),
    MeasuredQuantity("mean command", "motor", "A", recorded="commands"),
    MeasuredQuantity("settling time", "step", "s", needs="band", infinite="not settled"),
    MeasuredQuantity("overshoot", "step", "1"),                # share of the step
    MeasuredQuantity("steady-state error", "step", "m"),
    MeasuredQuantity("peak deviation", "event", "m"),          # largest |e| in the window of the event
    MeasuredQuantity("recovery time", "event", "s", needs="band", infinite="not back"),
    MeasuredQuantity("integral absolute error", "event", "m.s"),
    MeasuredQuantity("rms current", "effort", "A", recorded="currents"),      # of a phase
    MeasuredQuantity("ohmic loss", "effort", "J", recorded="currents"),          # of all phases
    MeasuredQuantity("command noise", "effort", "A", recorded="commands"),
    MeasuredQuantity("lowest", "column", needs="columns"),     # value over the run
    MeasuredQuantity("highest", "column", needs="columns"),
    MeasuredQuantity("largest", "column", needs="columns"))    # absolute value

# Deviations are relative, except for that of the equilibrium current. L is the thrust per current.
PROCEDURE_VALUES = by_name(
    MeasuredQuantity("constant", "procedure", needs="constant"),           # estimate
    MeasuredQuantity("average constant", "procedure", needs="constant"),   # mean over the air gaps
    MeasuredQuantity("thrust", "procedure"),                        # L at an air gap, by parabola fit, m/(s² A)
    MeasuredQuantity("estimated thrust", "procedure"),              # L at an air gap, by the estimator
    MeasuredQuantity("estimator deviation", "procedure", "1"),      # of L by the estimator from L by parabola fit
    MeasuredQuantity("simultaneous deviation", "procedure", "1"),   # of L with both axes moving from L with one
    MeasuredQuantity("equilibrium current", "procedure", "A"),      # measured
    MeasuredQuantity("equilibrium deviation", "procedure", "A"),    # of the predicted current from the measured one
    MeasuredQuantity("cogging force", "procedure", "N"),            # peak
    # RMS of model - stage over RMS of the stage's motion
    MeasuredQuantity("position deviation", "procedure", "1"),
    MeasuredQuantity("speed deviation", "procedure", "1"))


def in_words(column: str) -> str:
    """Return a recorded column in words, such as "speed of z" for "plant.z.velocity"; a name of one part unchanged."""
    _, *parts, last = column.split(".")
    known = {"velocity": "speed", "encoder": "encoder reading"}
    return f"{known.get(last, last.replace('_cmd', ' command'))} of {'.'.join(parts)}" if parts else column


def place_words(epsilon: float | None, gaps: tuple[float, float] | None) -> str:
    """Return the place of a procedure's value in words: at ε (s), in a range of air gaps (m)."""
    words = "" if epsilon is None else f", ε = {epsilon:g} s"
    if gaps is not None:
        low, high = (to_unit(gap, "mm") for gap in gaps)
        words += f", gap {low:g} mm" if low == high else f", gap {low:g} to {high:g} mm"
    return words
