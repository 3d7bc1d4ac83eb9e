"""Pictures as matplotlib draws them, an extra: that it is there, a figure to draw on, and one as a file."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from maglev.files.errors import extra
from maglev.files.whole_file import whole_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FAINT: dict[str, Any] = {"color": "0.6", "linewidth": 0.8}   # of a line that others are held against


def require_matplotlib() -> None:
    """Raise MaglevError if matplotlib, an extra of this project, is not installed."""
    extra("matplotlib", "report", "a picture")


def new_figure(width: float, height: float) -> "Figure":
    """An empty figure, sides in inches, that notebooks show by themselves; MaglevError without matplotlib."""
    require_matplotlib()
    from maglev.files.shown_figure import ShownFigure

    return ShownFigure(figsize=(width, height), layout="constrained")


def write_figure(path: Path, figure: "Figure") -> None:
    """Write a figure as PNG; the folder is made if it is not there."""
    with whole_file(path) as unfinished:
        figure.savefig(unfinished, dpi=110, format="png")
