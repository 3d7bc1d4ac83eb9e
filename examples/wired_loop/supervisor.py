"""A supervisor that stops a motion while the stage does not follow it."""


class Supervisor:
    """Sets `hold` while the error of the air gap exceeds a limit, until it is below half of the limit."""

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
