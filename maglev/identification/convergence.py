"""Convergence of the estimates as CSV and as a picture."""

from importlib.util import find_spec
from pathlib import Path

import numpy as np

from maglev.files.arrays import Array
from maglev.files.pictures import new_figure, write_figure
from maglev.files.whole_file import write_whole
from maglev.identification.identify import Identification

ROWS = 2000   # of the CSV, at most about


def convergence_table(identified: Identification) -> tuple[list[str], Array]:
    """Header and rows: time, every constant, the excitation of every axis."""
    estimate = identified.estimate
    every = max(1, len(estimate.time) // ROWS)
    kept = np.unique([*range(0, len(estimate.time), every), len(estimate.time) - 1])
    time = estimate.time[kept]
    excitation = [np.interp(time, d.time, d.excitation, left=0.0) for d in identified.diagnostics.values()]
    return (["time", *estimate.names, *(f"excitation.{axis}" for axis in identified.diagnostics)],
            np.column_stack([time, estimate.theta[kept], *excitation]))


def write_convergence(path: Path, identified: Identification) -> None:
    header, rows = convergence_table(identified)
    text = [",".join(header), *(",".join(map(repr, row)) for row in rows.tolist())]
    write_whole(path, "\n".join(text) + "\n")


def write_convergence_picture(stem: Path, identified: Identification) -> Path | None:
    """Write `stem`.png: every constant over time with its standard error at the end, and the excitation.

    None without matplotlib, an extra.
    """
    if find_spec("matplotlib") is None:
        return None
    header, rows = convergence_table(identified)
    names = identified.estimate.names
    figure = new_figure(10, 1.8 * (len(names) + 1))
    estimate = identified.estimate
    figure.suptitle(f"{identified.recording.stage.name}: {estimate.method} estimator, ε = {estimate.epsilon:g} s")
    panels = figure.subplots(len(names) + 1, 1, sharex=True)
    for k, name in enumerate(names):
        value, error = rows[-1, 1 + k], identified.standard_error[name]
        panels[k].plot(rows[:, 0], rows[:, 1 + k], linewidth=1.0)
        if np.isfinite(error):
            panels[k].axhspan(value - error, value + error, color="0.85")
        low, high = sorted((identified.guess[name], value))
        room = 0.2 * (high - low) + 0.05 * abs(value)
        panels[k].set_ylim(low - room, high + room)   # the first samples may swing far
        panels[k].set_ylabel(name)
    for k, axis in enumerate(identified.diagnostics):
        panels[-1].plot(rows[:, 0], rows[:, 1 + len(names) + k], linewidth=1.0, label=axis)
    panels[-1].set_ylabel("excitation")
    panels[-1].legend(loc="upper left", fontsize="small", ncols=3)
    panels[-1].set_xlabel("time (s)")
    path = stem.with_name(stem.name + ".png")
    write_figure(path, figure)
    return path
