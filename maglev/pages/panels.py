"""The one table of the panels that runs are drawn in, for every picture and page."""

from typing import Any, Literal, NamedTuple

from maglev.files.units import unit_of
from maglev.scenario.quantities import PRINTED_UNITS


class PanelKind(NamedTuple):
    of: Literal["axis", "motor", "column"]   # what it shows; a column is an output of a user's own
    name: str                    # its title, with {} for an axis or motor
    unit: str                    # SI, of its values; metres become radians on a rotation
    tolerance: float             # SI, of the lines in a page; of a user's outputs a share of the largest value
    digits: int                  # of a readout, behind the point
    floor: float | None = None   # SI, from which on it is logarithmic; None: linear
    place: bool = False          # where the axis is: of an air gap drawn downwards, as the gap grows

    def printed_unit(self, axis_unit: str = "m") -> str:
        """Unit in which it is drawn, such as mm; mrad if the axis is in rad."""
        unit = self.unit.replace("m", axis_unit, 1)
        return PRINTED_UNITS.get(unit, unit)

    @property
    def scale(self) -> float:
        """Return the number of drawn units in one SI unit."""
        return 1.0 / unit_of(self.printed_unit() or "1").factor

    @property
    def drawn_floor(self) -> float | None:
        """The floor in the unit in which it is drawn."""
        return None if self.floor is None else self.scale * self.floor

    def words(self, of: str, gap: bool = False) -> str:
        """Title without the unit, such as "speed of x"; it says where an axis is an air gap."""
        return self.name.format(f"gap {of}" if gap else of)

    def title(self, of: str, axis_unit: str = "m", gap: bool = False) -> str:
        """Title with the unit, such as "speed of x (mm/s)" or "gap y (mm)"."""
        unit = self.printed_unit(axis_unit)
        return self.words(of, gap) + (f" ({unit})" if unit else "")

    def data(self, of: str, axis_unit: str = "m", gap: bool = False) -> dict[str, Any]:
        """Return its data for the scripts of pages."""
        # The ticks of a logarithmic one have units.
        return {"of": of, "title": self.words(of, gap) if self.floor else self.title(of, axis_unit, gap),
                **self.reading(axis_unit), "floor": self.drawn_floor, "down": self.place and gap}

    def reading(self, axis_unit: str = "m") -> dict[str, Any]:
        """Return the data with which scripts print a value: `reading` of pages/scale.js."""
        return {"unit": self.printed_unit(axis_unit), "scale": self.scale, "digits": self.digits}


PANELS = {
    "position": PanelKind("axis", "{}", "m", 1e-6, 4, place=True),   # with the reference
    "speed": PanelKind("axis", "speed of {}", "m/s", 0.2e-3, 2),
    "error": PanelKind("axis", "|error| of {}", "m", 0.2e-6, 4, floor=1e-6),
    "commands": PanelKind("motor", "{} commands", "A", 20e-3, 3),
    "currents": PanelKind("motor", "{} currents", "A", 20e-3, 3),
    "own": PanelKind("column", "{}", "", 1e-4, 6)}   # of an output that no FMU of this project has


def panel_kinds(*shown: str) -> tuple[str, ...]:
    """Kinds of panels that show an axis, a motor, a column."""
    return tuple(kind for kind, panel in PANELS.items() if panel.of in shown)
