"""Modulation of the attraction between magnets and iron along the slots (cogging, sections 4.4.3 and 5.4.3)."""

from pmlsm.sine_cosine import sine_of_turns


def attraction_factor(modulation: float, displacement: float, slot_pitch: float) -> float:
    """Factor 1 − k sin²(π d/t1) on the attraction at a displacement d, slot pitch t1 (m); its form is assumed."""
    if modulation == 0.0:
        return 1.0
    return 1.0 - 0.5 * modulation * (1.0 - sine_of_turns(displacement / slot_pitch + 0.25))   # sin² x = (1 − cos 2x)/2
