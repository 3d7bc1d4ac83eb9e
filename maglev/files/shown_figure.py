"""A figure of matplotlib that notebooks show, pyplot or not."""

from io import BytesIO
from typing import Any

from matplotlib.figure import Figure


class ShownFigure(Figure):
    """A figure bound to no window, which shows itself where nothing has told the notebook how to show figures.

    Its titles, labels and legends are text as it is, and no TeX between dollars: files of users have them.
    """

    def draw(self, renderer: Any) -> None:
        """Draw, with the numbers at the ticks alone in TeX."""
        texts = [*self.texts]
        for axes in self.axes:
            texts += [axes.title, axes.xaxis.label, axes.yaxis.label, *axes.texts]
        for legend in filter(None, [*self.legends, *(axes.get_legend() for axes in self.axes)]):
            texts += [legend.get_title(), *legend.get_texts()]
        for text in texts:
            text.set_parse_math(False)
        super().draw(renderer)

    def _repr_png_(self) -> bytes:
        with BytesIO() as file:
            self.savefig(file, format="png")
            return file.getvalue()
