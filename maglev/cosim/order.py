"""Orders in which the FMUs of a co-simulation can step."""

from typing import Literal

Order = Literal["sequential", "jacobi"]   # one after the other (Gauss-Seidel), or all with what the step before gave
