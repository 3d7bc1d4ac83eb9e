"""What the controllers' FMUs show of themselves: icons and block diagrams, by the names of their modules."""

from fmi_export.definition import Drawing

ICONS = "controller_fmu.drawings.icons"
DIAGRAMS = "controller_fmu.drawings.block_diagrams"

# Of a class that somebody has written in a Python file.
WRITTEN_ICON = Drawing(ICONS, "controller", ("written",))
WRITTEN_SKETCH = Drawing(DIAGRAMS, "own_class")
