"""Compared runs over frequency: margins and curves of one loop agree, spectra have the power of what was recorded."""

from dataclasses import replace

import numpy as np
import pytest
from report_runs import packaged, recorded

from maglev.linear.loop import linearise_loop
from maglev.pages.frequency import QUANTITIES, margins_section, sensitivity, spectrum


def test_the_peak_of_the_curve_is_the_peak_of_the_margins() -> None:
    loop = linearise_loop("Plant2DOF", "PID2DOF", {"v": "20 mm"})
    frequencies, decibels = sensitivity(loop, "v")
    margins, k = loop.margins("v"), int(np.argmax(decibels))
    assert decibels[k] == pytest.approx(20.0 * np.log10(margins.sensitivity_peak), abs=0.02)
    assert frequencies[k] == pytest.approx(margins.sensitivity_frequency / (2.0 * np.pi), rel=0.02)
    assert QUANTITIES["delay margin"](replace(margins, delay=0.0123)) == "12.3 ms"
    assert QUANTITIES["gain margin"](replace(margins, gain_up=float("inf"), gain_down=0.5)) == "from 0.5 times on"


def test_a_sinusoid_is_in_its_band_alone_with_its_rms() -> None:
    time = np.arange(20000.0) / 1e3
    middles, values = spectrum(time, [3.0 * np.sin(2.0 * np.pi * 40.0 * time), 4.0 * np.cos(2.0 * np.pi * 40.0 * time)])
    k = int(np.argmax(values))
    assert abs(np.log2(middles[k] / 40.0)) < 1.0 / 6.0
    assert values[k] == pytest.approx(5.0 / np.sqrt(2.0), rel=1e-3)
    assert np.nansum(np.delete(values, k)) < 1e-2


def test_noise_has_its_power_in_all_bands() -> None:
    values = np.random.default_rng(5).normal(size=2**16)
    middles, bands = spectrum(np.arange(float(len(values))) / 1e3, [values])
    assert np.sqrt(np.sum(bands**2)) == pytest.approx(np.sqrt(middles[-1] * 2.0 ** (1.0 / 6.0) / 500.0), rel=0.03)


def test_names_loops_without_a_linear_model() -> None:
    run = recorded(packaged("2dof-setpoints"))
    said, curves = margins_section({"mine": run})
    assert said == "<p>mine is left out here: no plant and controller of this project are in it.</p>" and not curves
