"""Constants of a stage from a recording."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from maglev.files.errors import IdentificationError, one_of, option
from maglev.files.side_by_side import warn
from maglev.files.table import given_table, read_table
from maglev.files.table_times import Gaps
from maglev.files.units import number_or_text, parse_quantity, refused_as
from maglev.identification.identify import Identification
from maglev.identification.identify import identify as identified
from maglev.identification.model_file import write_convergence, write_convergence_picture, write_model
from maglev.identification.recording import read_recording
from maglev.identification.settings import EPSILON, GAMMA

Data = str | Path | Mapping[str, Any] | Any


def identify(data: Data, *, columns: Mapping[str, str] | None = None, units: Mapping[str, str] | None = None,
             gaps: Gaps = "refuse", stage: str | None = None, method: str = "reduced", epsilon: float | str = EPSILON,
             gamma: float = GAMMA, guess: Mapping[str, float | str] | None = None,
             matched: bool = False) -> Identification:
    """Identify the constants of a stage from recorded data.

    Parameters
    ----------
    data : path, Run, mapping of str to array_like, or DataFrame
        The columns, or a CSV with them: `time` (s), the positions `v`, `h` or `y`, `x`, `z` (m) and the delivered
        currents (A). These are `i_d`, `i_q` or `i_a`, `i_b`, `i_c`; with two motors `alpha.i_d`, `beta.i_d` …. Of a
        CSV of another layout a warning lists the assumptions.
    columns : mapping of str to str, optional
        Names of the columns in the data, by these names: {"time": "t", "v": "gap"}.
    units : mapping of str to str, optional
        Units of columns without a unit: {"v": "mm", "time": "ms"}.
    gaps : "refuse", "fill" or "longest"
        Treatment of times that are uneven by more than 5 %: an error with the first, straight lines over them, or the
        longest even part.
    stage : str, optional
        "2dof", "3dof", "5dof", or the description of your own stage, "mine.toml". If not given, it is that of the
        scenario of a `Run`, or one of the first three by the columns.
    method : "reduced", "full" or "fsdi"
        Estimator (3.8), (3.6) or (3.3).
    epsilon : float or str
        Confidence level ε of the measurement, s or with a unit.
    gamma : float
        Attenuation γ, more than 1.
    guess : mapping of str to float, optional
        Initial values by constant.
    matched : bool
        Filter positions and currents as the observer filters the velocity.

    Returns
    -------
    Identification
        `estimate.final` has the constants. `uncertainty` has their uncertainties: twice the scatter, `standard_error`,
        plus `left_out`, the effect of friction, bias, ripple and modulation, which the model leaves out. `warnings`
        lists the unknown effects.

    Raises
    ------
    MaglevError
        If the data or a setting cannot be used.
    """
    path = data_path(data)
    table = read_table(path) if isinstance(data, str | Path) else given_table(str(path), data)
    recording = read_recording(table.renamed(columns or {}, units),
                               stage or getattr(getattr(data, "plan", None), "stage_file", None), gaps)
    if recording.said:
        warn(recording.said)
    with refused_as(IdentificationError, option("epsilon", epsilon)):
        seconds = parse_quantity(number_or_text(epsilon) if isinstance(epsilon, str) else epsilon, "s")
    start = {}
    valid = recording.stage.constants
    for name, value in (guess or {}).items():
        asked = option("guess", {name: value})
        if name not in valid:
            raise IdentificationError(f"{asked}: expected a value, such as C1=10, of "
                                      f"{one_of(name, valid)}")
        with refused_as(IdentificationError, asked):
            start[name] = parse_quantity(number_or_text(value) if isinstance(value, str) else value, "1")
    try:
        return identified(recording, method, seconds, gamma, start, matched)
    except IdentificationError as error:
        raise IdentificationError(f"{path}: {error}") from None


def data_path(data: Data) -> Path:
    """Path of data, or a name for those that have none."""
    return Path(data if isinstance(data, str | Path) else getattr(data, "name", "data"))


def write_identification(found: Identification, data: Data, out: str | Path = "results") -> list[Path]:
    """Write `NAME.identified.toml`, for `run(…, model=…)`, and `NAME.convergence.csv` with a picture of it.

    Parameters
    ----------
    found : Identification
    data : path, Run, mapping or DataFrame
        The recording, whose name the files have; "data" if it has none.
    out : path
        Folder for the files.
    """
    folder, name = Path(out), data_path(data).stem
    model, convergence = folder / f"{name}.identified.toml", folder / f"{name}.convergence.csv"
    write_model(model, found, data_path(data))
    write_convergence(convergence, found)
    picture = write_convergence_picture(folder / f"{name}.convergence", found)
    return [model, convergence, *([] if picture is None else [picture])]
