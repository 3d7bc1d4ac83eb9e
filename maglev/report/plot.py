"""Picture of a run: positions with their references, absolute errors, commands and phase currents."""

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fmi_export.whole_file import whole_file
from maglev.cosim.master import Recording
from maglev.errors import ScenarioError
from maglev.schema.run_plan import RunPlan

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SMALLEST_ERROR = 1e-3   # mm, lower end of the logarithmic error axis
FAINT = {"color": "0.6", "linewidth": 0.8}


def require_matplotlib() -> None:
    """Raise ScenarioError if matplotlib, an extra of this project, is not installed."""
    if find_spec("matplotlib") is None:
        raise ScenarioError("--plot needs matplotlib, expected it to be installed: pip install 'maglev-fmus[report]'")


def plot(path: Path, plan: RunPlan, recording: Recording) -> None:
    """Write a PNG of a recording."""
    with whole_file(path) as unfinished:
        figure_of(plan, recording).savefig(unfinished, dpi=110, format="png")


def figure_of(plan: RunPlan, recording: Recording) -> "Figure":
    """Draw a recording: a row for each axis and each motor.

    Parameters
    ----------
    plan : RunPlan
        Names the columns of axes and motors, and the settling bands.
    recording : Recording

    Returns
    -------
    matplotlib.figure.Figure
        Bound to no window: save it, or show it in a notebook.
    """
    from matplotlib.figure import Figure  # an extra: only who plots needs it

    time, columns = recording.time, recording.columns
    rows = len(plan.axes) + len(plan.motors)
    figure = Figure(figsize=(12, 2.3 * max(rows, 1)), layout="constrained")
    figure.suptitle(f"{plan.name}: {plan.title}")
    if not rows:
        figure.text(0.5, 0.5, "no axis and no motor", horizontalalignment="center")
        return figure
    panels = figure.subplots(rows, 2, sharex=True, squeeze=False)
    for (name, axis), (left, right) in zip(plan.axes.items(), panels, strict=False):
        position, reference = 1e3 * columns[axis.position], 1e3 * columns[axis.reference]
        left.plot(time, reference, **FAINT, label="reference")
        left.plot(time, position, linewidth=1.0, label="position")
        left.set_ylabel(f"{name} (mm)")
        left.legend(loc="upper right", fontsize="small")
        right.semilogy(time, np.maximum(np.abs(position - reference), SMALLEST_ERROR), linewidth=0.8)
        for band in plan.metrics.bands:
            right.axhline(1e3 * band, **FAINT, linestyle="--")
        right.set_ylabel(f"|error| of {name} (mm)")
    for (name, motor), (left, right) in zip(plan.motors.items(), panels[len(plan.axes):], strict=True):
        # Of the commands the direct and the quadrature current; the phases are on the right, as delivered.
        commands = [command for command in motor.commands if "i_d" in command or "i_q" in command]
        for panel, names, what in ((left, commands, "commands"), (right, motor.currents, "phase currents")):
            for variable in names:
                panel.plot(time, columns[variable], linewidth=0.8, label=variable.rpartition(".")[2])
            panel.set_ylabel(f"{name} {what} (A)")
            if names:
                panel.legend(loc="upper right", fontsize="small", ncols=3)
    for panel in panels[-1]:
        panel.set_xlabel("time (s)")
    return figure
