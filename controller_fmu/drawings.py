"""Drawings of the controllers' FMUs, icons and block diagrams, by the names of their modules."""

from maglev.fmi.definition import Drawing

ICONS = "controller_fmu.icons"
DIAGRAMS = "controller_fmu.block_diagrams"

# Icon of a class in a user's Python file.
WRITTEN_ICON = Drawing(ICONS, "controller", ("written",))
WRITTEN_SKETCH = Drawing(DIAGRAMS, "own_class")
