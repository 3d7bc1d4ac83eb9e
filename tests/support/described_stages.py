"""Descriptions of stages of a user's, made of what `maglev new stage` writes."""

from pathlib import Path

from maglev.user.new_stage import new_stage

# A motor with a gap of 3 mm, as makers sell them, whose data sheet has rms values and no normal force by currents.
SMALL = {"sample_time = 0.0005": "sample_time = 0.0001", "mass = 4.35 ": "mass = 12 ",
         "start = 0.02 ": "start = 0.003 ",
         "lower = 0.008, upper = 0.028": "lower = 0.0015, upper = 0.005", "resolution = 1e-05": "resolution = 1e-06",
         "pole_pitch = 0.05715": "pole_pitch = 0.016", "slot_pitch = 0.01905": "slot_pitch = 0.005333",
         "slot_width = 0.0127": "slot_width = 0.0025", "magnet_height = 0.005": "magnet_height = 0.004",
         'currents = "peak"': 'currents = "rms"', "force_constant = 10.65": "force_constant = 30",
         "at = 0.02 ": "at = 0.003 ",
         "attraction = 38.95": "attraction = 110", "attraction_gap = 0.02 ": "attraction_gap = 0.003 ",
         "peak = 9.0": "peak = 6.0", "continuous = 7.0": "continuous = 3.0", "direct_constant =": "# direct_constant =",
         "iron_attraction =": "# iron_attraction =", "lower = 0.008\nupper = 0.04": "lower = 0.001\nupper = 0.006",
         "gaps = [0.008": "B0 = 0.6\ndecay = 0.006\n# gaps = [0.008", "B = [": "# B = [",
         "coulomb = 2.0": "coulomb = 0.5"}


def written(path: Path, like: str, changes: dict[str, str]) -> Path:
    """Description that begins like a stage's, with other texts instead of some."""
    new_stage(path, like)
    text = path.read_text(encoding="utf-8")
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return path
