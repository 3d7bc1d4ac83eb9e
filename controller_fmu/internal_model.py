"""Internal model of steps and of sinusoids of one frequency (4.15), (5.10), discretised exactly."""

from pmlsm.sine_cosine import sine_cosine


def integral_of_sine(x: float) -> float:
    """(x − sin x)/x³, the integral of an oscillator's step response; a series where the difference would cancel."""
    if x < 0.5:
        s = x * x
        return (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0 * (1.0 - s / 110.0 * (1.0 - s / 156.0))))) / 6.0
    sine, cosine = sine_cosine(x)
    return (x - sine) / (x * x * x)


class OscillatorStep:
    """Exact sample of ξ' = φ ξ + N e with constant e: ξ₊ = Φ ξ + Γ e, the same for every axis of a controller."""

    def __init__(self) -> None:
        self.cosine = 1.0       # Φ22, Φ33
        self.sine = 0.0         # Φ12, Φ23 and Γ3, s
        self.versine = 0.0      # Φ13 and Γ2, s²
        self.ramp = 0.0         # Γ1, s³
        self.minus_sine = 0.0   # Φ32, 1/s

    def prepare(self, omega0: float, sample_time: float) -> None:
        """Compute Φ and Γ for a frequency ω0 (rad/s, not negative) and a sample time (s)."""
        angle = omega0 * sample_time
        half = 0.5 * angle
        sine_half, cosine_half = sine_cosine(half)
        sine_whole, self.cosine = sine_cosine(angle)
        shrink = 1.0
        if half > 0.0:
            shrink = sine_half / half
        self.sine = sample_time * shrink * cosine_half
        self.versine = 0.5 * sample_time * sample_time * shrink * shrink
        self.ramp = sample_time * sample_time * sample_time * integral_of_sine(angle)
        self.minus_sine = -omega0 * omega0 * self.sine


class InternalModel:
    """State ξ of the internal model of one axis."""

    def __init__(self) -> None:
        self.xi1 = 0.0   # m s³, state
        self.xi2 = 0.0   # m s², state
        self.xi3 = 0.0   # m s, state

    def update(self, error: float, oscillator: OscillatorStep,
               correction1: float, correction2: float, correction3: float) -> None:
        """Take in a tracking error (m), and add the antiwindup's corrections of the three states."""
        xi1 = self.xi1
        xi2 = self.xi2
        xi3 = self.xi3
        self.xi1 = (xi1 + oscillator.sine * xi2 + oscillator.versine * xi3 + oscillator.ramp * error) + correction1
        self.xi2 = (oscillator.cosine * xi2 + oscillator.sine * xi3 + oscillator.versine * error) + correction2
        self.xi3 = (oscillator.minus_sine * xi2 + oscillator.cosine * xi3 + oscillator.sine * error) + correction3
