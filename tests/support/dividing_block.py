"""A block that raises where Python's numbers end: it divides by its input, and takes the square root of it."""

from math import sqrt

from maglev.fmi.definition import DefaultExperiment, FmuDefinition, real_input, real_output


class Divider:
    """Reciprocal and root of a number."""

    def __init__(self) -> None:
        self.number = 1.0       # input
        self.reciprocal = 1.0   # output
        self.root = 1.0         # output

    def start(self) -> int:
        """Nothing can be wrong with a start."""
        return 0

    def step(self, t: float, dt: float) -> int:
        """Compute, without a look at what it is given."""
        self.reciprocal = 1.0 / self.number
        self.root = sqrt(self.number)
        return 0


DIVIDER = FmuDefinition(
    name="Divider", block=Divider, description="Divides by what it is given.",
    variables=(real_input("number", "m", "what is divided by", 10.0, 1.0),
               real_output("reciprocal", "", "1 over it", 1.0), real_output("root", "", "its square root", 1.0)),
    refusals={}, experiment=DefaultExperiment(stop_time=1.0, step=0.1), variable_step=True)
