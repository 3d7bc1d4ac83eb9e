"""plotly.js, an extra of this project, which draws the plots of a study."""

from importlib import import_module
from importlib.util import find_spec

from maglev.errors import ScenarioError


def require_plotly() -> None:
    """Raise ScenarioError if plotly is not installed."""
    if find_spec("plotly") is None:
        raise ScenarioError("the page of a study needs plotly, expected it to be installed: "
                            "pip install 'maglev-fmus[report]'")


def plotly_script() -> str:
    """plotly.js as plotly brings it along."""
    # An extra without types.
    return str(import_module("plotly.offline").get_plotlyjs())
