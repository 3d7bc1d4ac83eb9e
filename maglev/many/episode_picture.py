"""Picture of a stage in an episode: from the side and, where the platform moves in two directions, from above."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from maglev.files.arrays import Array
from maglev.files.pictures import FAINT, new_figure
from pmlsm.stage_description import StageDescription

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIZE = (480, 240)   # px
DPI = 80
LENGTH = 0.25       # of the mover, as a share of the way that it can go
WHERE: dict[str, Any] = {"color": "tab:blue", "linewidth": 5.0}
WANTED: dict[str, Any] = {"color": "tab:orange", "linewidth": 1.2, "linestyle": "--"}


class StagePicture:
    """Draws a stage; `travel` has the ends of each axis (m, rad). MaglevError without matplotlib."""

    def __init__(self, stage: StageDescription, travel: Sequence[tuple[float, float]]):
        self.stage = stage
        names = stage.axis_names
        self.gap, self.ways = names.index(stage.vertical.name), [names.index(axis.name) for axis in stage.horizontal]
        self.tilts = [names.index(axis.name) for axis in stage.rotations[1:]]   # the pitch, which is about z
        self.figure = new_figure(SIZE[0] / DPI, SIZE[1] / DPI)
        self.figure.set_dpi(DPI)
        views = self.figure.subplots(1, 1 if len(self.ways) < 2 else 2, squeeze=False)[0]
        self.half = 0.5 * LENGTH * (travel[self.ways[0]][1] - travel[self.ways[0]][0])
        side = self.view(views[0], [travel[i] for i in (self.ways[0], self.gap)], (self.ways[0], self.gap))
        side.invert_yaxis()   # the gap grows downwards
        side.margins(x=0.5 * LENGTH)
        self.lines = [side.plot([], [], **style)[0] for style in (WHERE, WANTED)]
        self.points = []
        if len(self.ways) > 1:
            above = self.view(views[1], [travel[i] for i in self.ways[:2]], self.ways[:2])
            self.points = [above.plot([], [], mark, color=color, markersize=10)[0]
                           for mark, color in (("o", "tab:blue"), ("x", "tab:orange"))]
        self.figure.suptitle(" ")

    def view(self, axes: "Axes", ends: Sequence[tuple[float, float]], shown: Sequence[int]) -> "Axes":
        """A view on two axes of the stage, in mm, with their ends."""
        for (low, high), line in zip(ends, (axes.axvline, axes.axhline), strict=True):
            line(1e3 * low, **FAINT)
            line(1e3 * high, **FAINT)
        axes.set_xlabel(f"{self.stage.axis_names[shown[0]]}, mm")
        axes.set_ylabel(f"{self.stage.axis_names[shown[1]]}, mm")
        return axes

    def drawn(self, positions: Array, references: Array, time: float) -> npt.NDArray[np.uint8]:
        """Return a picture of the stage and its references (m, rad, of each axis) at a time (s), shape (240, 480, 3).
        """
        for line, places in zip(self.lines, (positions, references), strict=True):
            slope = sum(places[i] for i in self.tilts)
            x, y = places[self.ways[0]], places[self.gap]
            line.set_data(1e3 * (x + self.half * np.array([-1.0, 1.0])),
                          1e3 * (y + self.half * slope * np.array([-1.0, 1.0])))
        for point, places in zip(self.points, (positions, references), strict=False):   # none from above
            point.set_data(*([1e3 * places[i]] for i in self.ways[:2]))
        self.figure.suptitle(f"{time:.3f} s")
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        canvas: Any = FigureCanvasAgg(self.figure)
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
