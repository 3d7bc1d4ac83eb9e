"""Write the table of docs/linear_models.md anew: margins of the examples and of two laws of ours, linear and flown.

    python tools/measured_margins.py results/margins.json              # minutes: one solves a programme every sample

What was measured is kept in the file; what is in it already is not measured again.
"""

import json
import sys
from math import degrees, inf
from pathlib import Path
from typing import Any

import maglev

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "linear_models.md"
BEGIN, END = "<!-- margins -->\n", "<!-- end of margins -->"
CONTROLLERS = {"nonlinear regulator": "Regulator3DOF", "PID": "PID3DOF", **{
    f"`{name}`": f"examples/{name}.py" for name in ("lqi_kalman", "h_infinity", "mpc_osqp", "disturbance_observer")}}
AXES = ("y", "x")
MARGINS = (("gain_down", 1.0, ""), ("gain_up", 1.0, ""), ("phase", degrees(1.0), "°"), ("delay", 1e3, " ms"),
           ("sensitivity_peak", 1.0, ""), ("disk", 1.0, ""))
HEAD = ["| controller | at | | gain down to | gain up to | phase | delay | Ms | disk |", f"|{'---|' * 9}"]


def measured(controller: str, axis: str) -> dict[str, Any]:
    """What was found of one controller at one axis, as JSON has it."""
    file = ROOT / controller if controller.endswith(".py") else controller
    found = maglev.frequency_response("Plant3DOF", file, {"y": "25 mm"}, axis, lowest=2.0, highest=1500.0)
    return found[f"{axis}.measured"].as_data()


def cell(value: float | None, error: float | None, by: float, unit: str) -> str:
    """A margin, with its error if it was flown; None of one that no line tells."""
    if value is None:
        return "beyond"
    text = "–" if value in (0.0, inf) else f"{by * value:.3g}"
    return text + (f" ± {float(f'{by * error:.1g}'):g}" if error is not None else "") + (unit if text != "–" else "")


def rows(name: str, axis: str, found: dict[str, Any]) -> list[str]:
    """Rows of the table of one controller at one axis."""
    linear, flown, errors = found["linear_margins"], found["margins"], found["margin_errors"]
    first = [cell(linear[key], None, by, unit) for key, by, unit in MARGINS] if linear else ["none", *[""] * 5]
    second = [cell(flown[key], errors[key], by, unit) for key, by, unit in MARGINS]
    return [f"| {name} | {axis} | linear | {' | '.join(first)} |", f"| | | flown | {' | '.join(second)} |"]


def main(kept: Path) -> None:
    """Measure what is not in the file, and write the table."""
    known = json.loads(kept.read_text()) if kept.is_file() else {}
    lines = list(HEAD)
    for name, controller in CONTROLLERS.items():
        for axis in AXES:
            key = f"{controller} {axis}"
            if key not in known:
                known[key] = measured(controller, axis)
                kept.parent.mkdir(parents=True, exist_ok=True)
                kept.write_text(json.dumps(known))
            lines += rows(name, axis, known[key])
    page = PAGE.read_text(encoding="utf-8")
    before, after = page.split(BEGIN)[0], page.split(END)[1]
    PAGE.write_text(before + BEGIN + "\n".join(lines) + "\n" + END + after, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
