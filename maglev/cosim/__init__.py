"""Co-simulation of FMUs: one FMU, its port map, the wiring of several, their steps."""

from typing import Literal

# Order of the FMUs in a step: one after the other (Gauss-Seidel), or all with the outputs of the step before.
Order = Literal["sequential", "jacobi"]
