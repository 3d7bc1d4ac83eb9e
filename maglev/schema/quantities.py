"""What can be measured and claimed: the metrics of a run and the values that a procedure finds, with their units."""

import math
from typing import Literal, NamedTuple

from maglev.units import to_unit

PRINTED_UNITS = {"s": "s", "1": "%", "m": "mm", "rad": "mrad", "A": "A", "N": "N"}   # by the SI unit

# What a quantity is measured on, and the keys with which a claim may pick some of its values.
MeasuredOn = Literal["step", "tracking", "motor", "column", "run", "procedure"]
PICKED_BY: dict[MeasuredOn, tuple[str, ...]] = {
    "step": ("axes",), "tracking": ("axes",), "motor": ("motors",), "column": ("together_with",), "run": (),
    "procedure": ("epsilon", "axes", "gaps")}


class MeasuredQuantity(NamedTuple):
    """A measured quantity: what it is measured on, in what unit, and what a claim about it must give.

    Attributes
    ----------
    on : str
        A step of an axis, the tracking of an axis, a motor, a recorded column, the whole run, or a procedure.
    unit : str or None
        SI unit of measured values and of plain numbers as targets; None: a plain number. Of a count it is none, that
        of a constant depends on the constant, and a claim about a column gives its own.
    needs : str or None
        Key without which a claim does not say what it is about.
    infinite : str
        Words for an infinite value.
    yes_no : (str, str) or None
        Words for that it happened and that it did not; None of a number.
    words : str
        What it is called to readers; empty if by its name.
    """

    on: MeasuredOn
    unit: str | None = None
    needs: str | None = None
    infinite: str = "inf"
    yes_no: tuple[str, str] | None = None
    words: str = ""

    @property
    def of_axes(self) -> bool:
        """Whether each axis of a run has values of its own."""
        return self.on in ("step", "tracking")

    def printed(self, value: float | bool, axis_unit: str = "m") -> str:
        """Print a value with its unit; of an axis in rad its lengths are angles."""
        if self.yes_no:
            return self.yes_no[0] if value else self.yes_no[1]
        if math.isinf(value):
            return self.infinite
        if self.unit is None:
            return f"{value:.4g}"
        unit = PRINTED_UNITS[axis_unit if self.unit == "m" else self.unit]
        return f"{to_unit(value, unit):.3g} {unit}"


METRICS = {
    "settling_time": MeasuredQuantity("step", "s", needs="band", infinite="not settled"),
    "overshoot": MeasuredQuantity("step", "1"),                # share of the step
    "steady_state_error": MeasuredQuantity("step", "m", words="steady-state error"),
    "tracking_mean": MeasuredQuantity("tracking", "m", words="mean tracking error"),
    "tracking_peak": MeasuredQuantity("tracking", "m", words="largest tracking error"),
    "tracking_settling": MeasuredQuantity("tracking", "s", words="transient of tracking"),
    "peak_current": MeasuredQuantity("motor", "A"),
    "mean_current": MeasuredQuantity("motor", "A"),
    "peak_command": MeasuredQuantity("motor", "A"),
    "mean_command": MeasuredQuantity("motor", "A"),
    "lowest": MeasuredQuantity("column", needs="columns"),    # value over the run
    "highest": MeasuredQuantity("column", needs="columns"),
    "largest": MeasuredQuantity("column", needs="columns"),   # absolute value
    "trip_time": MeasuredQuantity("run", "s", infinite="never", words="time until the trip"),
    "lost_setpoints": MeasuredQuantity("run", words="set-points at which it failed"),
    "stop_contact": MeasuredQuantity("run", yes_no=("touched an end stop", "touched no end stop")),
    "tripped": MeasuredQuantity("run", yes_no=("tripped", "did not trip")),
    "failed": MeasuredQuantity("run", yes_no=("lost the stage", "kept the stage in the air"))}

# Deviations are shares of what they are from, but that of the equilibrium current. L is the thrust per current.
PROCEDURE_VALUES = {
    "constant": MeasuredQuantity("procedure", needs="constant"),           # estimate
    "average_constant": MeasuredQuantity("procedure", needs="constant"),   # mean over the air gaps
    "thrust": MeasuredQuantity("procedure"),                        # L at an air gap, by parabola fit, m/(s² A)
    "estimated_thrust": MeasuredQuantity("procedure"),              # L at an air gap, by the estimator
    "estimator_deviation": MeasuredQuantity("procedure", "1"),      # of L by the estimator from L by parabola fit
    "simultaneous_deviation": MeasuredQuantity("procedure", "1"),   # of L with both axes moving from L with one
    "equilibrium_current": MeasuredQuantity("procedure", "A"),      # measured
    "equilibrium_deviation": MeasuredQuantity("procedure", "A"),    # of the predicted current from the measured one
    "cogging_force": MeasuredQuantity("procedure", "N"),            # peak
    "position_deviation": MeasuredQuantity("procedure", "1"),       # RMS of model - rig over RMS of the rig's motion
    "speed_deviation": MeasuredQuantity("procedure", "1")}


def length(value: float, unit: str = "m") -> str:
    """A length in mm, or µm if it is small; of an axis in rad an angle in mrad or µrad."""
    milli = PRINTED_UNITS[unit]
    micro = milli.replace("m", "µ", 1)
    return f"{to_unit(value, milli):.3g} {milli}" if value >= 0.1e-3 else f"{to_unit(value, micro):.3g} {micro}"


def in_words(column: str) -> str:
    """A recorded column in words, such as "speed of z" of "plant.z.velocity"; one with no part by its name."""
    _, *parts, last = column.split(".")
    known = {"velocity": "speed", "encoder": "encoder reading"}
    return f"{known.get(last, last.replace('_cmd', ' command'))} of {'.'.join(parts)}" if parts else column


def place(epsilon: float | None, gaps: tuple[float, float] | None) -> str:
    """Words for where a procedure's value is looked for: at ε (s), in a range of air gaps (m)."""
    words = "" if epsilon is None else f", ε = {epsilon:g} s"
    if gaps is not None:
        low, high = (to_unit(gap, "mm") for gap in gaps)
        words += f", gap {low:g} mm" if low == high else f", gap {low:g} to {high:g} mm"
    return words
