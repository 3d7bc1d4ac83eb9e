"""Injected responses against the linear loop, and against the describing function of a rounding."""

import json
from collections.abc import Callable
from math import floor, isnan, nan, pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import error_line, maglev
from facts import raises, require_facts

from maglev.analysis.frequency_response import frequency_response
from maglev.analysis.response import FrequencyResponse, crest_factor, make_grid, multisine, untold
from maglev.files.errors import LinearModelError
from maglev.linear.margins import Margins, margins_between

STEP = 0.2e-3    # m, of the rounding


@pytest.mark.usefixtures("slow")
def test_a_multisine_has_its_lines_alone_and_its_peak(monkeypatch: pytest.MonkeyPatch) -> None:
    grid = make_grid(3.0, 300.0, 20, 1e-3)
    signal = multisine(grid, 2e-4, 5)
    spectrum = np.abs(np.fft.rfft(signal)) / len(signal)
    lines = list(grid.harmonics)
    assert np.abs(signal).max() == pytest.approx(2e-4)
    np.testing.assert_allclose(spectrum[lines], spectrum[lines[0]], rtol=1e-9)
    assert np.delete(spectrum, lines).max() < 1e-12 * spectrum[lines[0]]
    assert grid.frequencies[0] == pytest.approx(3.0, rel=1e-3)
    assert grid.frequencies[-1] <= 300.0
    clipped = np.mean([crest_factor(multisine(grid, 1.0, seed)) for seed in range(6)])
    monkeypatch.setattr("maglev.analysis.response.CLIPPINGS", 1)
    assert clipped < 0.9 * np.mean([crest_factor(multisine(grid, 1.0, seed)) for seed in range(6)])


def test_an_excitation_has_the_same_bits_with_another_fourier_transform(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whose last digits are a library's."""
    grid, transform = make_grid(3.0, 300.0, 20, 1e-3), np.fft.rfft
    signal = multisine(grid, 2e-4, 5)
    turned = 1.0 + 1e-13 * np.exp(1j * np.arange(grid.samples // 2 + 1))
    monkeypatch.setattr(np.fft, "rfft", lambda x: transform(x) * turned)
    assert multisine(grid, 2e-4, 5).tobytes() == signal.tobytes()
    monkeypatch.setattr("maglev.analysis.response.DIGITS", 15)
    assert multisine(grid, 2e-4, 5).tobytes() != signal.tobytes()


def response_of(controller: object, fmus: Path, **given: object) -> FrequencyResponse:
    """Of h of the 2-DOF stage, without what is not smooth in the plant, and in h without a bias."""
    found = frequency_response("Plant2DOF", controller, {"v": 20e-3}, "h", smooth=True, fmus=fmus,
                               plant_parameters={"h.bias": 0.0}, **{"settle": 3.0, **given})   # type: ignore[arg-type]
    return found["h.measured"]


def test_our_regulator_runs_as_its_linear_model(fastest_fmus: Path) -> None:
    """Response and margins within 0.2 %, of a stage that is a little nonlinear at 50 µm; as python-control has it."""
    control = pytest.importorskip("control")
    found = response_of("Regulator2DOF", fastest_fmus, amplitude="50 um", lowest=3.0, highest=1500.0, lines=30)
    assert found.linear_loop is not None
    np.testing.assert_allclose(found.loop, found.linear_loop, rtol=2e-3)
    assert found.coherence.min() > 0.9999
    simulated, linear = found.margins, found.linear_margins
    assert isinstance(linear, Margins)
    for name in ("gain_up", "phase", "delay", "sensitivity_peak", "disk"):
        assert getattr(simulated, name) == pytest.approx(getattr(linear, name), rel=3e-3), name
    system = found.to_control()
    assert isinstance(system, control.FrequencyResponseData)
    _, phase_margin, _, crossover = control.margin(system)
    assert phase_margin == pytest.approx(np.degrees(linear.phase), abs=0.5)
    assert crossover == pytest.approx(linear.phase_frequency, rel=0.02)
    found.plot()


def describing_function(amplitude: float) -> float:
    """Of a rounding to whole steps: sum of relays, each with a dead zone that ends at half a step more."""
    steps = floor(amplitude / STEP + 0.5)
    return 4.0 * STEP / (pi * amplitude) * sum(sqrt(1.0 - ((2 * k - 1) * STEP / (2.0 * amplitude)) ** 2)
                                              for k in range(1, steps + 1))


@pytest.mark.thorough
@pytest.mark.parametrize(("peak", "gain"), [(0.7, 1.18), (1.6, 1.04)])
def test_a_rounding_is_its_describing_function(peak: float, gain: float, fastest_fmus: Path, pd_class) -> None:
    """One sine: up to 1.5 steps the law is a relay with a dead zone. Its harmonics hardly come through the stage."""
    line = {"lowest": 300.0, "highest": 300.0, "lines": 1, "linear": False}
    rounding = ("        self.gap.update(", f"        self.h_measured = round(self.h_measured / {STEP}) * {STEP}\n"
                "        self.gap.update(")
    smooth = response_of(pd_class(), fastest_fmus, amplitude=20e-6, **line)
    rounded = response_of(pd_class(rounding), fastest_fmus, amplitude=peak * STEP, **line)
    seen = abs(rounded.measured.mean()) * peak * STEP
    assert abs(rounded.loop[0] / smooth.loop[0]) == pytest.approx(describing_function(seen), rel=0.02)
    assert describing_function(seen) == pytest.approx(gain, rel=0.03)
    assert abs(np.angle(rounded.loop[0] / smooth.loop[0])) < 0.03


def loop_between(response: Callable[[complex], complex], lowest: float,
                 highest: float) -> tuple[Margins, dict[str, str]]:
    """Margins of a loop that was measured between two frequencies (rad/s), and what they do not tell."""
    grid = np.geomspace(lowest, highest, 2000)
    values = np.array([response(1j * w) for w in grid])
    margins = margins_between("y", grid, values, lambda w: response(1j * w))
    return margins, untold(margins, grid, values)


def unstable(s: complex) -> complex:
    """K e^(−sT)/(s − 1): stable in a loop while 1 < K < 23.6, of which the lower end is at ω = 0."""
    return 4.0 * np.exp(-0.0636 * s) / (s - 1.0)


def integrator(s: complex) -> complex:
    """2 e^(−sT)/s: |L| = 1 at 2 rad/s, on the negative axis at π/(2T), Ms near it."""
    return 2.0 * np.exp(-0.1 * s) / s


@pytest.mark.quick
@pytest.mark.parametrize(("response", "lowest", "highest", "unknown"), [
    (unstable, 0.1, 200.0, {"gain_down"}),
    (unstable, 0.1, 10.0, {"gain_down", "gain_up", "sensitivity_peak", "sensitivity_frequency"}),
    (unstable, 0.1, 2.0, {"gain_down", "gain_up", "phase", "phase_frequency", "delay", "sensitivity_peak",
                          "sensitivity_frequency", "disk"}),
    (integrator, 0.1, 200.0, {"gain_down"}),
    (integrator, 5.0, 200.0, {"gain_down", "phase", "phase_frequency", "delay"})])
def test_margins_beyond_the_lines_are_unknown(response: Callable[[complex], complex], lowest: float, highest: float,
                                              unknown: set[str]) -> None:
    """Against the same loop at all frequencies: what is said to be known is what it is there."""
    everywhere, _ = loop_between(response, 1e-4, 1e3)
    margins, untold_of = loop_between(response, lowest, highest)
    assert set(untold_of) == unknown
    for name, value in vars(margins).items():
        if isinstance(value, float) and name not in unknown:
            assert value == pytest.approx(vars(everywhere)[name], rel=1e-6), name
    for name, why in untold_of.items():
        assert f"{lowest:.3g}" in why or f"{highest:.4g}" in why, name


def test_margins_beyond_the_lines_are_no_numbers(fastest_fmus: Path, tmp_path: Path) -> None:
    """As on the command line, so from Python and in JSON: NaN with a reason, and no error of 0."""
    found = response_of("Regulator2DOF", fastest_fmus, amplitude="50 um", lowest=60.0, highest=1500.0, lines=12,
                        linear=False, settle=1.0)
    assert isnan(found.margins.gain_down) and isnan(found.margin_errors["gain_down"])
    assert "?…" in str(found.margins)
    assert found.unknown["gain_down"].startswith("L does not cross the negative real axis beyond −1 from")
    assert not any(isnan(value) for name, value in found.margin_errors.items() if name not in found.unknown)
    data = json.loads(json.dumps(found.as_data(), allow_nan=False))
    assert data["margins"]["gain_down"] is data["margin_errors"]["gain_down"] is None
    assert data["margins_unknown"] == found.unknown
    text = str(found)
    assert "not among the lines" in text and "gain down to: L does not cross" in text
    assert max(map(len, text.splitlines())) <= 80


def test_command_line(fastest_fmus: Path, tmp_path: Path) -> None:
    file = tmp_path / "h.json"
    few = ("--fmus", fastest_fmus, "--settle", "1 s", "--from", "20", "--to", "600", "--lines", "8", "--periods", "1",
           "--realisations", "2", "--no-linear")
    done = maglev("linearise", "--measure", "Plant2DOF", "Regulator2DOF", "--at", "v=20mm", "--open", "h", *few,
                  "--json", file)
    assert done.exit_code == 0, done.output
    assert max(map(len, done.stdout.splitlines()[:-1])) <= 80
    data = json.loads(file.read_text(encoding="utf-8"))["h.measured"]
    assert len(data["loop"]) == len(data["coherence"]) == len(data["frequencies"]) == 8
    assert data["why_not_linear"] == "it was not asked for"
    assert 0.0 < data["margin_errors"]["phase"] < 0.3
    wrong = maglev("linearise", "--measure", "Plant2DOF", "Regulator2DOF", "--at", "v=20mm", "--open", "x", *few)
    require_facts(error_line(wrong), "'x'", "v.measured, h.measured")


def test_refuses_impossible_grids() -> None:
    with raises(LinearModelError, 10, "7000 rad/s", "6283.19 rad/s"):
        make_grid(10.0, 7000.0, 5, 0.5e-3)


@pytest.mark.parametrize(("options", "facts"), [
    ({"realisations": 1}, ["realisations", 1, 2]), ({"seed": -1}, ["seed", -1, 0]), ({"lines": 6.5}, ["lines", 6.5]),
    ({"lowest": "50 Hz"}, ["lowest", "'50 Hz'", "rad/s"]), ({"settle": nan}, ["settle", nan]),
    ({"settle": -1}, ["settle", -1])])
def test_refuses_impossible_options(fastest_fmus: Path, options: dict[str, Any], facts: list[object]) -> None:
    with raises(LinearModelError, *facts):
        frequency_response("Plant2DOF", "Regulator2DOF", {"v": 20e-3}, fmus=fastest_fmus, linear=False, **options)
