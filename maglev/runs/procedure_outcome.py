"""The outcome of a procedure: values at places, a table of constants, curves, and notes for the reader."""

from collections.abc import Sequence
from dataclasses import dataclass

from maglev.files.arrays import Array
from maglev.scenario.procedure import ProcedureSettings

Values = Sequence[float] | Array


@dataclass(frozen=True)
class ProcedureValue:
    """One value and its place, which is None if it has none."""

    name: str                      # see `maglev.scenario.quantities.PROCEDURE_VALUES`
    value: float                   # SI
    constant: str | None = None
    axis: str | None = None
    epsilon: float | None = None   # s
    gap: float | None = None       # air gap, m


@dataclass(frozen=True)
class Curve:
    """Points of a chart, shape (n,) each, joined by a line or marked one by one; curves of one kin have one colour.

    A line with a `margin` has a band about it, which reaches so far to both sides.
    """

    label: str
    x: Values
    y: Values
    marked: bool = False
    kin: str | None = None
    margin: Values | None = None


@dataclass(frozen=True)
class Panel:
    """Curves over one axis of abscissae; titles have the units."""

    x_title: str
    y_title: str
    curves: tuple[Curve, ...]


@dataclass(frozen=True)
class Chart:
    """A figure that is no time plot of a run: panels below each other; the number is the thesis's, if it has one."""

    number: str | None
    caption: str
    panels: tuple[Panel, ...]


@dataclass(frozen=True)
class ValueTable:
    """A table: header and rows of text, the first column names what the row is about."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Outcome:
    settings: ProcedureSettings
    runs: tuple[str, ...]           # names of those that it rests on
    values: tuple[ProcedureValue, ...] = ()
    tables: tuple[ValueTable, ...] = ()
    charts: tuple[Chart, ...] = ()
    notes: tuple[str, ...] = ()     # what a reader should know, such as a constant that cannot be identified
