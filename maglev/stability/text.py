"""Regions of stability as text and as plain data."""

from typing import TYPE_CHECKING, Any

from maglev.linear.text import aligned
from maglev.stability.certificate import LARGEST_STEP
from maglev.stability.simulation import Response

if TYPE_CHECKING:
    from maglev.stability.analysis import Candidate, Region


def text_of(region: "Region") -> str:
    """Limit, gains, and a row for each candidate."""
    loop = region.loop
    fly = region.candidates[0].flown is not None
    heads = ["antiwindup", "Ec", "certified (mm)", "simulated (mm)", "overshoot (%)", "settling (s)"]
    if fly:
        locked = region.candidates[0].flown
        heads += ["flown (mm)", *(["gap locked (mm)"] if locked and locked.largest_locked is not None else []),
                  "overshoot (%)", "settling (s)"]
    return (f"{loop.name}: {1e3 * loop.sample_time:g} ms, command {loop.at_rest:.4g} A at rest, "
            f"{loop.at_rest + loop.lower:g}…{loop.at_rest + loop.upper:g} A\n"
            f"largest steps; overshoot and settling into 0.1 mm for a step of {1e3 * region.step:.4g} mm\n\n"
            f"{aligned([heads, *(row(each) for each in region.candidates)])}\n")


def row(candidate: "Candidate") -> list[str]:
    """Cells of one candidate."""
    cells = [candidate.name, " ".join(f"{gain:.3g}" for gain in candidate.gains),
             f"{1e3 * candidate.certificate.step:.1f}",
             f"{'≥ ' if candidate.simulated >= LARGEST_STEP else ''}{1e3 * candidate.simulated:.1f}",
             *response_cells(candidate.response)]
    if candidate.flown is not None:
        flown = candidate.flown
        cells.append(f"{1e3 * flown.largest:.1f}")
        if flown.largest_locked is not None:
            cells.append(f"{1e3 * flown.largest_locked:.1f}")
        cells += response_cells(flown.response) if flown.held else ["not held", ""]
    return cells


def response_cells(response: Response) -> list[str]:
    """Overshoot and settling."""
    return [f"{100.0 * response.overshoot:.1f}", f"{response.settling:.2f}"]


def data_of(region: "Region") -> dict[str, Any]:
    """Region as plain data, SI; a settling time of null is one that does not end within the response."""
    loop = region.loop
    return {"name": loop.name, "axis": loop.axis, "sample_time": loop.sample_time, "states": list(loop.states),
            "command_at_rest": loop.at_rest, "lower": loop.lower, "upper": loop.upper, "step": region.step,
            "poles": [[rate.real, rate.imag] for rate in loop.rates.tolist()],
            "candidates": {each.name: candidate_data(each) for each in region.candidates}}


def candidate_data(candidate: "Candidate") -> dict[str, Any]:
    """One candidate as plain data."""
    found, flown = candidate.certificate, candidate.flown
    return {"Ec": found.gains.tolist(), "certified_step": found.step, "P": found.P.tolist(), "G": found.G.tolist(),
            "T": found.T, "decrease": found.decrease, "simulated_step": candidate.simulated,
            "simulated": response_data(candidate.response),
            "flown": None if flown is None else {
                "held": flown.held, "largest_step": flown.largest, "largest_step_gap_locked": flown.largest_locked,
                **response_data(flown.response)}}


def response_data(response: Response) -> dict[str, Any]:
    """Overshoot and settling as plain data."""
    settling = response.settling
    return {"overshoot": response.overshoot, "settling": settling if settling < float("inf") else None}
