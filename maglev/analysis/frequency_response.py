"""`frequency_response`: the response of a running loop with all its nonlinearities, by injection.

A multisine r is added to a measurement m = y + r between plant and controller. Of the loop opened there, L of 1 + L, L
= −Y/M at each line, whatever the controller is inside, and whether or not it has a derivative. Several multisines of
other phases show the linear part: the rest changes with the phases, and so does noise.

R. Pintelon, J. Schoukens, System Identification: A Frequency Domain Approach, 2nd ed., Wiley 2012, chapters 2 to 5.
"""

from collections.abc import Mapping, Sequence
from math import ceil
from pathlib import Path

import numpy as np

from maglev.analysis.numerical import linearised_here
from maglev.analysis.pair import SETTLE, AskedPair, Pair, Rest, Settings, apart, make_pair, resting_pair, with_fmus
from maglev.analysis.participant import Sign, no_sign
from maglev.analysis.response import FrequencyResponse, Grid, crest_factor, make_grid, multisine
from maglev.cosim.isolated_run import TIMEOUT
from maglev.files.arrays import Array, Complex
from maglev.files.errors import LinearModelError
from maglev.files.units import parse_quantity, refused_as, whole_number
from maglev.linear.loop import Loop, linearise_loop
from maglev.linear.parameters import Quantity, controllers, plants
from maglev.user.source import Given

AMPLITUDE = 100e-6   # m or rad, peak of the added signal
LINES = 48
LOWEST, HIGHEST = 1.0, 2000.0   # rad/s
REALISATIONS, PERIODS = 3, 2
LEAD = 4.0           # s, at least, until a loop has forgotten the multisine before


def frequency_response(plant: str | Path, controller: Given, at: Mapping[str, Quantity],
                       signals: str | Sequence[str] = (), *, amplitude: Quantity = AMPLITUDE,
                       lowest: Quantity = LOWEST, highest: Quantity = HIGHEST, lines: int = LINES,
                       realisations: int = REALISATIONS, periods: int = PERIODS, smooth: bool = False,
                       linear: bool = True, settle: float = SETTLE, seed: int = 1, fmus: str | Path | None = None,
                       kind: str | None = None, fmi: int = 2, ports: str | Path | None = None,
                       plant_parameters: Settings | None = None, controller_parameters: Settings | None = None,
                       sample_time: Quantity | None = None, stage: str | Path | None = None,
                       timeout: float = TIMEOUT) -> dict[str, FrequencyResponse]:
    """Simulate a loop with a multisine on a measurement, and return the response of the loop opened there.

    The loop is measured as it runs at that amplitude: with friction, rounding, limits.

    Parameters
    ----------
    signals : str or sequence of str
        Measurements, one after the other, such as "y" or "y.measured"; of a platform that tilts "roll.measured" or
        "alpha1.gap_measured"; that of every axis if not given.
    amplitude : float or str
        Peak of the added signal, m or rad or with a unit.
    lowest, highest : float or str
        rad/s or with a unit; a period takes 2π/lowest.
    lines, realisations, periods : int
        Frequencies; multisines, at least two; periods that are recorded of each, after those of at least 4 s.
    smooth : bool
        Simulate without Coulomb friction and rounding of the encoders, as in the linear model.
    linear : bool
        Also compute the linear loop: from the equations if both FMUs are of this project, otherwise by differences.
    settle, timeout : float
        Longest time before the measurement, s; for the timeout see `linearise_numerically`.
    seed : int
        Of the phases.
    plant, controller, at, ports, plant_parameters, controller_parameters, sample_time, stage, fmus, kind, fmi
        See `AskedPair`, and `run` for the last three.

    Returns
    -------
    dict of str to FrequencyResponse
        By the full name of the signal.

    Raises
    ------
    LinearModelError, FmuError, ControllerError, ScenarioError
        See `make_pair` and `resting_pair`; also raised if the grid or a signal cannot be used.
    """
    for name, number, least in (("lines", lines, 1), ("realisations", realisations, 2), ("periods", periods, 1),
                                ("seed", seed, 0)):   # what two realisations differ by is the error
        whole_number(number, LinearModelError, name, least)
    with refused_as(LinearModelError, "lowest, highest"):
        ends = parse_quantity(lowest, "rad/s"), parse_quantity(highest, "rad/s")
    signals = (signals,) if isinstance(signals, str) else tuple(signals)
    asked = with_fmus(AskedPair(plant, controller, at, Path(), ports, plant_parameters, controller_parameters,
                                sample_time, stage), signals, False, fmus, kind, fmi)
    return apart(responses_here, asked.sources, timeout, asked, signals, amplitude, (*ends, lines),
                 range(seed, seed + realisations), periods, settle, smooth, linear)


def responses_here(asked: AskedPair, signals: tuple[str, ...], amplitude: Quantity, lines: tuple[float, float, int],
                   seeds: range, periods: int, settle: float, smooth: bool, linear: bool, sign: Sign = no_sign
                   ) -> dict[str, FrequencyResponse]:
    pair = make_pair(asked, smooth)
    names = [pair.opening(signal) for signal in signals or pair.stage.axis_names]
    grid = make_grid(*lines, pair.step)
    peaks = [read_amplitude(pair, name, amplitude) for name in names]
    loop, why_not = linear_loop_of(asked, settle, sign) if linear else (None, "it was not asked for")
    with resting_pair(pair, settle, strict=False, sign=sign) as rest:
        return {name: measured_at(rest, name, peak, grid, seeds, periods, loop, why_not)
                for name, peak in zip(names, peaks, strict=True)}


def measured_at(rest: Rest, name: str, peak: float, grid: Grid, seeds: range, periods: int, loop: Loop | None,
                why_not: str) -> FrequencyResponse:
    signals = [multisine(grid, peak, seed) for seed in seeds]
    lead = max(1, ceil(LEAD / grid.period))
    added = np.concatenate([np.tile(signal, lead + periods) for signal in signals])
    reference = np.array([np.fft.rfft(signal)[list(grid.harmonics)] for signal in signals])[:, None]
    answers, seen = (spectra(grid, signal, lead, periods).reshape(len(signals), periods, -1) / reference
                     for signal in injected(rest, name, added))
    power = (np.abs(answers) ** 2).mean(axis=(0, 1))
    coherence = np.abs(answers.mean(axis=(0, 1))) ** 2 / np.where(power > 0.0, power, 1.0)
    return FrequencyResponse(rest.pair.name, name, rest.equilibrium, grid, peak,
                             float(np.mean([crest_factor(signal) for signal in signals])), periods,
                             answers.mean(axis=1), seen.mean(axis=1), coherence, loop, why_not)


def read_amplitude(pair: Pair, name: str, amplitude: Quantity) -> float:
    """Return the peak of the signal added to a measurement, m or rad."""
    axis = next((known for known in pair.stage.axes if known.name == name.rpartition(".")[0]), None)
    with refused_as(LinearModelError, "amplitude"):
        size = parse_quantity(amplitude, "m" if axis is None else axis.unit("m"))
    if not 0.0 < size < 1.0:
        raise LinearModelError(f"amplitude = {size:g}, expected more than 0 and less than 1 m or rad")
    return size


def linear_loop_of(asked: AskedPair, settle: float, sign: Sign) -> tuple[Loop | None, str]:
    """Return the linear loop, from the equations of this project or by differences; or None, and the reason."""
    if asked.plant in plants() and asked.controller in controllers() and asked.sample_time is None:
        plant, law = str(asked.plant), str(asked.controller)
        return linearise_loop(plant, law, asked.at, plant_parameters=asked.plant_parameters,
                              controller_parameters=asked.controller_parameters), ""
    numerical = linearised_here(asked, (), False, settle, sign)
    return numerical.loop, numerical.why_not


def injected(rest: Rest, name: str, added: Array) -> tuple[Array, Array]:
    """Continue the run with a signal (m or rad) added to one; return the returned −y and the measured values,
    (samples,).

    They are deviations from the point of rest.
    """
    read, changed = rest.pair.openings[name]
    way, references = changed.tolist(), list(rest.pair.references.values())
    rest.controller.back()
    rest.plant.back()
    measured: Sequence[float] = rest.measured.tolist()
    rows = np.empty((len(added), len(way)))
    for k, push in enumerate(added.tolist()):
        rows[k] = measured
        seen = [value + by * push for value, by in zip(measured, way, strict=True)]
        measured = rest.plant.step(rest.controller.step([*seen, *references]))
    true = (rows - rest.measured) @ read
    return -true, true + added * float(read @ changed)


def spectra(grid: Grid, signal: Array, lead: int, periods: int) -> Complex:
    """Spectra at the lines, shape (multisines · periods, lines), of the periods after the lead of each multisine."""
    parts = signal.reshape(-1, lead + periods, grid.samples)[:, lead:].reshape(-1, grid.samples)
    return np.asarray(np.fft.rfft(parts, axis=1)[:, list(grid.harmonics)])
