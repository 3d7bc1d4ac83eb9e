"""Identified constants as a TOML file, and back as start values of a scenario's FMUs; and their convergence."""

from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import IdentificationError, in_one_line, nearest, one_of, shortened
from maglev.files.pictures import new_figure, write_figure
from maglev.files.regular_file import regular
from maglev.files.toml_file import read_toml
from maglev.files.whole_file import write_whole
from maglev.identification.regressors import ESTIMATED_STAGES, estimated_stage
from pmlsm.stage_description import StageDescription

if TYPE_CHECKING:
    from maglev.identification.identify import Identification

FMUS = ("plant", "controller")
CONSTANTS = max((stage.constants for stage in ESTIMATED_STAGES.values()), key=len)   # of a file that names no stage
BEGINNING = "# Identified by maglev identify"
END = "# end of the constants"   # a number that was cut is a number, too
SMALLEST = 1e-9   # the controllers divide by them
LARGEST = 1e12
ROWS = 2000   # of the CSV of the convergence, at most about


def write_model(path: Path, model: "Identification", source: Path) -> None:
    """Write the constants for the plant and for the controller's model; one that is not identified stays a comment."""
    lines = [f"{BEGINNING} from {in_one_line(source.name)}: {model.estimate.method} estimator, "
             f"epsilon = {model.estimate.epsilon:g} s, gamma = {model.estimate.gamma:g}.",
             "# For maglev run SCENARIO --model FILE: it sets the constants of the plant and of the controller's model",
             "# Behind the values: the standard error, which is scatter from one recording to another, and a bound of",
             "# the bias that all of them have, by friction, bias, ripple and modulation, which the model leaves out.",
             *(f"# {in_one_line(warning)}" for warning in model.warnings), "",
             f'stage = "{model.recording.stage.name}"']
    for fmu in FMUS:
        lines += ["", f"[{fmu}]"]
        for name, value in model.estimate.final.items():
            usable = value >= SMALLEST and name not in model.unidentified
            errors = f"scatter {model.standard_error[name]:.2g}, bias at most {model.left_out[name]:.2g}"
            lines.append(f"{name} = {value!r}   # {errors}" if usable else
                         f"# {name} = {value!r} is not identified: the FMU keeps its own")
    write_whole(path, "\n".join([*lines, "", END]) + "\n")


def model_settings(path: Path, stage: StageDescription | None = None) -> dict[str, float]:
    """Values of a model file by `plant.C1`, ….

    The file has tables `[plant]` and `[controller]` with constants `C1`…`C5`; constants outside the tables go to both,
    and those of a table go before them. `stage = "2dof"` may say which stage they belong to, by its name.

    ScenarioError or IdentificationError if the file cannot be read, is for another stage than the scenario's, or has an
    unknown key or a value that is no number above 0.
    """
    table = read_toml(path)
    text = regular(path).read_text(encoding="utf-8-sig")
    if text.startswith(BEGINNING) and not text.rstrip().endswith(END):
        raise IdentificationError(f"{path}: ends with {shortened(text[-20:])}, expected the line {END!r}: the file was "
                                  "cut")
    named = table.pop("stage", None)
    known = {**ESTIMATED_STAGES, **({} if stage is None else {stage.name: estimated_stage(stage)})}
    if named is not None and (not isinstance(named, str) or named not in known):
        raise IdentificationError(f"{path}: stage = {named!r}: expected {one_of(str(named), known)}")
    if named is not None and stage is not None and named != stage.name:
        raise IdentificationError(f"{path}: stage = {named!r}: expected constants of the stage {stage.name}, "
                                  "the scenario's")
    belongs = stage.name if named is None and stage is not None else named
    valid = CONSTANTS if belongs is None else known[belongs].constants
    tables = {name: table.pop(name, {}) for name in FMUS}
    both = checked(path, "", table, valid, (*valid, *FMUS, "stage"))
    settings: dict[str, float] = {}
    for fmu, own in tables.items():
        if not isinstance(own, dict):
            raise IdentificationError(f"{path}: {fmu} = {own!r}: expected a table [{fmu}]")
        values = {**both, **checked(path, f"{fmu}.", own, valid, valid)}
        settings |= {f"{fmu}.{name}": values[name] for name in sorted(values)}
    if not settings:
        raise IdentificationError(f"{path}: has no constants, expected C1 = … in [plant], in [controller] or for both")
    return settings


def checked(path: Path, above: str, table: Mapping[str, Any], valid: tuple[str, ...], keys: tuple[str, ...]
            ) -> dict[str, float]:
    """Constants of a table, each a number above 0."""
    constants = {}
    for key, value in table.items():
        if key not in valid:
            raise IdentificationError(f"{path}: {above}{key}: unknown key, {nearest(key, keys)}")
        if isinstance(value, bool) or not isinstance(value, int | float) or not (
                SMALLEST <= value <= LARGEST):
            raise IdentificationError(f"{path}: {above}{key} = {value!r}: expected a number above 0")
        constants[key] = float(value)
    return constants


def convergence_table(identified: "Identification") -> tuple[list[str], Array]:
    """Header and rows: time, every constant, the excitation of every axis."""
    estimate = identified.estimate
    every = max(1, len(estimate.time) // ROWS)
    kept = np.unique([*range(0, len(estimate.time), every), len(estimate.time) - 1])
    time = estimate.time[kept]
    excitation = [np.interp(time, d.time, d.excitation, left=0.0) for d in identified.diagnostics.values()]
    return (["time", *estimate.names, *(f"excitation.{axis}" for axis in identified.diagnostics)],
            np.column_stack([time, estimate.theta[kept], *excitation]))


def write_convergence(path: Path, identified: "Identification") -> None:
    header, rows = convergence_table(identified)
    text = [",".join(header), *(",".join(map(repr, row)) for row in rows.tolist())]
    write_whole(path, "\n".join(text) + "\n")


def write_convergence_picture(stem: Path, identified: "Identification") -> Path | None:
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
