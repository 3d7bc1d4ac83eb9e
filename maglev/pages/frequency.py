"""Compared runs over frequency: margins and sensitivity of their loops, and spectra of their signals."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from html import escape
from math import degrees, inf, pi
from typing import Any

import numpy as np

from maglev.descriptions.registry import known_stages
from maglev.files.arrays import Array
from maglev.files.errors import LinearModelError
from maglev.linear.equilibrium import spelled
from maglev.linear.loop import Loop, linearise_loop
from maglev.linear.margins import Margins, frequencies_of
from maglev.linear.parameters import controllers, plants
from maglev.pages.charts import rounded
from maglev.pages.figures import error_of, recorded_columns
from maglev.pages.findings import html_table, typeset
from maglev.pages.lines import DASHES
from maglev.pages.series import thin
from maglev.runs.execution import RunResult
from maglev.scenario.quantities import printed

SLOWEST = 0.1      # Hz, where curves of the sensitivity begin
FAINTEST = -80.0   # dB, lower bound of the drawn values: an internal model leaves nothing at its frequency
SMOOTH = 0.05      # dB, of the points that are left out
MOST_POINTS = 400
FEWEST = 64        # samples of a recording that has a spectrum
THIRD = 2.0 ** (1.0 / 3.0)   # of an octave: width of a band

Curve = tuple[Array, Array]   # frequencies, Hz, and values


def margins_section(runs: Mapping[str, RunResult]) -> tuple[str, dict[str, dict[str, Curve]]]:
    """Return the table of margins with a sentence for each controller that has none, and sensitivities by axis, dB."""
    loops, left_out = dict[str, Loop](), []
    margins: dict[str, dict[str, Margins]] = {}
    for label, run in runs.items():
        try:
            loop = loop_of(run)
            margins[label] = {axis: loop.margins(axis) for axis in run.plan.axes}
            loops[label] = loop
        except LinearModelError as why:
            left_out.append(f"<p>{escape(label)} is left out here: {typeset(str(why))}.</p>")
    if not loops:
        return "".join(left_out), {}
    axes = next(iter(margins.values()))
    place = next(iter(loops.values())).plant.equilibrium
    at = ", ".join(spelled(place.stage, place.positions, *place.positions))
    rows = [(f"{name} of {escape(axis)}", *(text(margins[label][axis]) for label in loops))
            for axis in axes for name, text in QUANTITIES.items()]
    return (f"<p>Margins of each loop, opened at the measurement of an axis, from its equations about the last "
            f"setpoints ({typeset(at)}). The sensitivity is the share of an output disturbance that remains; at 0 dB "
            f"all of it remains.</p>{html_table(('quantity', *loops), rows, look='cards numbers')}"
            + "".join(left_out),
            {axis: {label: sensitivity(loop, axis) for label, loop in loops.items()} for axis in axes})


# Format of each margin.
QUANTITIES: dict[str, Callable[[Margins], str]] = {
    "gain margin": lambda of: f"{of.gain_down:.2g} to {of.gain_up:.3g} times" if of.gain_up < inf else
                              f"from {of.gain_down:.2g} times on",
    "phase margin": lambda of: f"{degrees(of.phase):.0f}° at {of.phase_frequency / (2.0 * pi):.3g} Hz",
    "delay margin": lambda of: printed(of.delay, "s"),
    "largest sensitivity": lambda of: f"{of.sensitivity_peak:.3g} at {of.sensitivity_frequency / (2.0 * pi):.3g} Hz"}


def loop_of(run: RunResult) -> Loop:
    """Return the linear loop of a run where its references end; LinearModelError, a reason, where there is none."""
    fmus = {fmu.name: fmu for fmu in run.provenance.fmus} if run.provenance is not None else {}
    if not {"plant", "controller"} <= fmus.keys() or not len(run.time):
        raise LinearModelError("no plant and controller of this project are in it")
    for name, known in (("plant", plants()), ("controller", controllers())):
        if not (fmus[name].built_here and fmus[name].model in known):
            raise LinearModelError(f"there are no equations of its {name}, {fmus[name].shown}; maglev linearise finds "
                                   "the margins of a file by differences")
    set_by = {name: {variable.name: fmu.start[variable.name]
                     for variable in known_stages().definition(fmu.model).variables
                     if variable.causality == "parameter" and variable.name in fmu.start}
              for name, fmu in fmus.items() if fmu.built_here}
    at = {name: float(run.columns[axis.reference][-1]) for name, axis in run.plan.axes.items()}
    return linearise_loop(fmus["plant"].model, fmus["controller"].model, at, plant_parameters=set_by["plant"],
                          controller_parameters=set_by["controller"],
                          measurement=fmus["measurement"].model if "measurement" in fmus else None,
                          measurement_parameters=set_by.get("measurement"))


def sensitivity(loop: Loop, axis: str) -> Curve:
    """Frequencies, Hz, and the gain of the sensitivity of a loop opened at an axis, dB."""
    opened = loop.opened(axis)
    rates = frequencies_of(opened)
    rates = rates[rates >= 2.0 * pi * SLOWEST]
    gain = np.abs(1.0 / (1.0 + opened.frequency_response(rates)[:, 0, 0]))
    decibels = np.maximum(20.0 * np.log10(np.maximum(gain, 1e-300)), FAINTEST)
    rows, _ = thin(np.log10(rates), decibels, SMOOTH, MOST_POINTS)
    return rates[rows] / (2.0 * pi), decibels[rows]


def spectrum(time: Array, signals: Sequence[Array]) -> Curve:
    """RMS of signals together in bands of a third of an octave, from evenly spaced samples, s, each of shape (n,).

    Returns the middles of the bands, Hz, and the values, in the unit of the signals. A window of Hann keeps what ends
    at another value than it began with out of higher bands.
    """
    step, count = float(time[-1] - time[0]) / (len(time) - 1), len(time)
    window = np.hanning(count)
    frequencies = np.fft.rfftfreq(count, step)
    power = sum(np.abs(np.fft.rfft(window * signal)) ** 2 for signal in signals) * 2.0 / (count * np.sum(window ** 2))
    first = 4.0 / (count * step)   # below it a band has no two lines
    bands = first * THIRD ** np.arange(int(np.log(0.5 / step / first) / np.log(THIRD)) + 1)
    place = np.digitize(frequencies, bands)
    inside = (place > 0) & (place < len(bands))
    total = np.bincount(place[inside], np.asarray(power)[inside], len(bands))[1:]
    return bands[:-1] * THIRD ** 0.5, np.sqrt(np.where(total > 0.0, total, np.nan))


def spectra(runs: Mapping[str, RunResult]) -> dict[str, dict[str, Curve]]:
    """Return spectra by title and label: the error of each axis, in mm or mrad, and all phases of each motor, in mA."""
    found: dict[str, dict[str, Curve]] = {}
    for label, run in runs.items():
        time, columns = run.time, recorded_columns(run)
        if len(time) < FEWEST or not np.allclose(np.diff(time), time[1] - time[0]):
            continue
        for title, names in spectrum_columns(run):
            if columns.keys() >= {*names}:
                found.setdefault(title, {})[label] = spectrum(time, [1e3 * columns[name] for name in names])
    return found


def spectrum_columns(run: RunResult) -> Iterator[tuple[str, list[str]]]:
    """Titles of panels and the columns that they show."""
    for name, axis in run.plan.axes.items():
        yield f"error of {name} (m{axis.unit})", [error_of(axis)]
    for name, motor in run.plan.motors.items():
        yield f"currents of {name} (mA)", list(motor.currents)


def frequency_charts(sensitivities: Mapping[str, Mapping[str, Curve]], of_runs: Mapping[str, Mapping[str, Curve]],
                     colours: Mapping[str, int]) -> dict[str, dict[str, Any]]:
    """Data of the charts for the page's scripts, by the names of their places."""
    dashes = {label: DASHES[k % len(DASHES)] for k, label in enumerate(colours)}

    def panel(title: str, curves: Mapping[str, Curve], logarithmic: str = "") -> dict[str, Any]:
        return {"x": "frequency (Hz)", "y": title, "decades": True, "logarithmic": logarithmic, "curves": [
            {"label": label, "kin": label, "css": f"run-{colours[label]}", "dash": dashes[label], "marked": False,
             "x": rounded(x, 4), "y": rounded(y, 4)} for label, (x, y) in curves.items()]}

    charts = {"sensitivity": [panel(f"sensitivity of {axis} (dB)", curves) for axis, curves in sensitivities.items()],
              "spectra": [panel(title, curves, title.rpartition("(")[2].rstrip(")"))
                          for title, curves in of_runs.items()]}
    return {name: {"runs": [], "chart": panels} for name, panels in charts.items() if panels}
