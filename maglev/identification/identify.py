"""From a recording to constants: velocities, estimator, diagnostics, replay."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from maglev.arrays import Array
from maglev.errors import IdentificationError
from maglev.identification.diagnostics import RowDiagnostics, diagnose, unidentified, warnings_of
from maglev.identification.estimators import Estimate, estimate
from maglev.identification.recording import Recording
from maglev.identification.replay import replay
from maglev.identification.rigs import regressors
from maglev.identification.settings import EPSILON, GAMMA
from maglev.identification.velocity import matched, observed


@dataclass(frozen=True)
class Identification:
    """An estimate with what is known about it.

    Attributes
    ----------
    recording : Recording
    estimate : Estimate
    guess : dict of str to float
    matched : bool
        Whether y and u went through the observer's filters.
    diagnostics : dict of str to RowDiagnostics
        By axis.
    standard_error, with_friction : dict of str to float
        By constant.
    replay_error, replay_motion : ndarray, shape (axes,)
        m, see `replay`.
    warnings : list of str
    unidentified : list of str
        Constants that the recording does not tell.
    """

    recording: Recording
    estimate: Estimate
    guess: dict[str, float]
    matched: bool
    diagnostics: dict[str, RowDiagnostics]
    standard_error: dict[str, float]
    with_friction: dict[str, float]
    replay_error: Array
    replay_motion: Array
    warnings: list[str]
    unidentified: list[str]


def identify(recording: Recording, method: str = "reduced", epsilon: float = EPSILON, gamma: float = GAMMA,
             guess: Mapping[str, float] | None = None, match: bool = False, velocities: Array | None = None,
             q0: float | None = None) -> Identification:
    """Estimate the constants of a rig from a recording.

    Parameters
    ----------
    recording : Recording
    method, epsilon, gamma, q0
        See `estimate`.
    guess : mapping of str to float, optional
        Initial values; those of the estimator FMU for constants that are not named.
    match : bool
        Put positions and currents through the filters that the observer's velocity has gone through.
    velocities : ndarray, shape (n, axes), optional
        m/s; by default those of the high-gain observer.

    Raises
    ------
    IdentificationError
        If no axis is excited, or see `estimate`.
    """
    rig, dt = recording.rig, recording.dt
    start = {**rig.guess, **(guess or {})}
    seen = observed(recording.positions, dt) if velocities is None else velocities
    positions, i_d, i_q = recording.positions, recording.i_d, recording.i_q
    if match:
        positions, i_d, i_q = (matched(signal, dt) for signal in (positions, i_d, i_q))
    rows = regressors(rig, positions, i_d, i_q, seen)
    estimates = estimate(method, rows, recording.time, start, epsilon, gamma, q0)
    travel = np.ptp(recording.positions, axis=0).tolist()
    diagnostics = {data.row.axis: diagnose(data, way, recording.time, estimates)
                   for data, way in zip(rows, travel, strict=False)}   # tilts have no row of constants
    if not any(found.excited for found in diagnostics.values()):
        ways = ", ".join(f"{axis} {1e3 * way:.3g} mm" for axis, way in zip(rig.axes, travel, strict=True))
        raise IdentificationError(f"no axis is excited: they move over {ways}, expected motion on all axes, as with "
                                  "the excitation of sections 4.3.1 and 5.3, and currents that change")
    errors: dict[str, float] = {}
    friction: dict[str, float] = {}
    warnings: list[str] = []
    unknown: list[str] = []
    for data in rows:
        found = diagnostics[data.row.axis]
        errors.update(zip(data.row.constants, found.standard_error.tolist(), strict=True))
        friction.update(zip(data.row.constants, found.with_friction.tolist(), strict=True))
        warnings += warnings_of(data, found, estimates)
        unknown += unidentified(data, found, estimates)
    error, motion = replay(recording, estimates.final)
    return Identification(recording, estimates, start, match, diagnostics, errors, friction, error, motion,
                          sorted(warnings), sorted(unknown))
