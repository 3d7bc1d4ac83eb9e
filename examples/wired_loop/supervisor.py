"""Stops a movement while the stage does not follow it."""


class Supervisor:
    """Asks for a halt while the error of the air gap is beyond a limit, until it is back within half of it."""

    inputs = {"v.error": "m"}
    outputs = {"hold": ""}
    parameters = {"limit": "m"}

    def __init__(self) -> None:
        self.limit = 0.5e-3
        self.v_error = 0.0
        self.hold = False

    def step(self, t: float, dt: float) -> None:
        """Judge the error."""
        if abs(self.v_error) > self.limit:
            self.hold = True
        elif abs(self.v_error) < 0.5 * self.limit:
            self.hold = False
