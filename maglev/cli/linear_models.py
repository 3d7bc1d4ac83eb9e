"""Linear models on the command line: computes those that `maglev linearise` is asked for, and prints them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees
from pathlib import Path
from textwrap import fill
from typing import Any

import typer

import maglev
from maglev.cli.terminal import write_json
from maglev.files.errors import LinearModelError
from maglev.files.pictures import write_figure
from maglev.files.text_columns import aligned
from maglev.files.units import number_or_text
from maglev.linear.loop import Loop, opening_among, openings_of, write_bode, write_nyquist
from maglev.linear.margins import Margins
from maglev.linear.model import poles_text
from maglev.linear.parameters import Quantity, controllers, measurements, plants

LINE = 80   # letters


@dataclass(frozen=True)
class Asked:
    """The parsed arguments of the command."""

    names: Sequence[str]                         # a plant, a controller, or both
    at: Mapping[str, Quantity]                   # positions by axis
    parameters: Mapping[str, dict[str, Any]]     # of "plant", "controller" and "measurement"
    openings: Sequence[str]                      # signals at which the loop is opened; none: those of every axis
    how: Mapping[str, Any]                       # options of loops whose FMUs are run, such as stage and settle
    pictures: Path | None                        # folder, where they are asked for
    json: Path | None                            # file, where it is asked for

    @property
    def both(self) -> dict[str, Any]:
        """Return parameters as arguments of functions of a plant and a controller."""
        return {f"{part}_parameters": values for part, values in self.parameters.items() if part != "measurement"}

    def write(self, data: Mapping[str, object]) -> None:
        if self.json is not None:
            write_json(self.json, data)


def of_one(asked: Asked, hold: str | None, **options: Any) -> None:
    """Print the linear model of a plant or a controller."""
    name, = asked.names
    # Options of a plant's model do not apply to a controller: `linearise` raises an error for them.
    own = "controller" if name in controllers() else "measurement" if name in measurements() else "plant"
    for other, given in asked.parameters.items():
        if given and other != own:
            raise LinearModelError(f"--set {other}.{next(iter(given))}: expected {own}.… with {name}")
    sample_time = None if hold is None else number_or_text(hold)
    model = maglev.linearise(name, asked.at, hold=sample_time, parameters=asked.parameters[own], **options)
    typer.echo(str(model), nl=False)
    asked.write(model.as_data())


def of_loop(asked: Asked, amplifier: bool) -> None:
    """Print poles and margins of a loop of this project's plants and controllers, from their equations."""
    plant, *between, controller = asked.names
    for name in asked.openings if plant in plants() else ():
        opening_among(name, openings_of(plants()[plant], "phases" if between else "dq"), f"{plant} with {controller}")
    asked.write(print_loop(asked, maglev.linearise_loop(
        plant, controller, asked.at, amplifier=amplifier, **asked.both, measurement=next(iter(between), None),
        measurement_parameters=asked.parameters["measurement"])))


def by_differences(asked: Asked) -> None:
    """Print poles and margins of the loop of any plant or controller, by differences of their responses."""
    plant, controller = asked.names
    numerical = maglev.linearise_numerically(plant, controller, asked.at, openings=asked.openings, **asked.both,
                                             **asked.how)
    if numerical.loop is None:
        typer.echo(f"{numerical.pair.name}\n\n{numerical}")
        asked.write({"name": numerical.pair.name, **numerical.as_data()})
        numerical.linear()   # raises the error: this loop has no linear model
        return
    data = print_loop(asked, numerical.loop)
    typer.echo(f"\n{numerical}")
    asked.write({**data, **numerical.as_data(),
                 "errors": {signal: numerical.errors(signal) for signal in data["margins"]}})


def print_measured(asked: Asked, amplitude: str, **injection: Any) -> None:
    """Print the frequency responses and margins of a loop, measured by injection."""
    plant, controller = asked.names
    responses = maglev.frequency_response(plant, controller, asked.at, asked.openings,
                                          amplitude=number_or_text(amplitude), **injection, **asked.both, **asked.how)
    typer.echo("\n".join(map(str, responses.values())), nl=False)
    data: dict[str, Any] = {signal: response.as_data() for signal, response in responses.items()}
    for signal, response in responses.items() if asked.pictures is not None else ():
        picture = Path(str(asked.pictures)) / f"{Path(plant).stem}-{Path(controller).stem}-{signal}.response.png"
        write_figure(picture, response.plot())
        data[signal]["picture"] = str(picture)
        typer.echo(f"picture: {picture}")
    asked.write(data)


def print_loop(asked: Asked, loop: Loop) -> dict[str, Any]:
    """Print the poles and margins of a loop, write its pictures, and return them as data."""
    signals = tuple(loop.opening(name) for name in asked.openings or loop.measured)
    typer.echo(f"{loop.closed.name}, sampled every {1e3 * (loop.plant.sample_time or 0.0):g} ms\n"
               f"{fill(f'about {loop.plant.equilibrium}', LINE)}\n\n"
               f"poles, as rates ln(z)/Ts\n{poles_text(loop.rates)}\n")
    of_signals = {signal: loop.margins(signal) for signal in signals}
    typer.echo(aligned([["opened at", "gain", "phase", "at", "delay", "Ms", "disk", "gain with phase"],
                        ["", "factor", "°", "rad/s", "ms", "", "", "factor, °"],
                        *(margin_cells(margins) for margins in of_signals.values())]))
    data: dict[str, Any] = {
        "name": loop.closed.name, "sample_time": loop.plant.sample_time,
        "poles": [[pole.real, pole.imag] for pole in loop.poles.tolist()],
        "margins": {signal: vars(margins) for signal, margins in of_signals.items()}}
    if asked.pictures is not None:
        data["pictures"] = write_pictures(asked.pictures, loop, signals)
    return data


def margin_cells(margins: Margins) -> list[str]:
    low, high = margins.disk_gain
    return [margins.at, f"{margins.gain_down:.3g}…{margins.gain_up:.3g}", f"{degrees(margins.phase):.1f}",
            f"{margins.phase_frequency:.4g}", f"{1e3 * margins.delay:.3g}", f"{margins.sensitivity_peak:.3g}",
            f"{margins.disk:.3g}", f"{low:.2f}…{high:.2f}, {degrees(margins.disk_phase):.0f}°"]


def write_pictures(out: Path, loop: Loop, signals: tuple[str, ...]) -> list[str]:
    """Write Bode and Nyquist pictures, and return their paths."""
    stem = f"{loop.plant.name}-{loop.controller.name}"
    bode, nyquist = out / f"{stem}.bode.png", out / f"{stem}.nyquist.png"
    write_bode(bode, loop, signals)
    write_nyquist(nyquist, loop, signals)
    typer.echo(f"pictures: {bode}, {nyquist}")
    return [str(bode), str(nyquist)]
