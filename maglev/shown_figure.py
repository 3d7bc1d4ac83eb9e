"""A figure of matplotlib that notebooks show, pyplot or not."""

from io import BytesIO

from matplotlib.figure import Figure


class ShownFigure(Figure):
    """A figure bound to no window, which shows itself where nothing has told the notebook how to show figures."""

    def _repr_png_(self) -> bytes:
        with BytesIO() as file:
            self.savefig(file, format="png")
            return file.getvalue()
