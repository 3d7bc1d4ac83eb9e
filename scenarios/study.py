"""What one run of a study gives: its scenario, what was recorded and measured, or why it failed."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.metrics import Metrics
from scenarios.scenario import Scenario


@dataclass(frozen=True)
class RunResult:
    """One run of a study.

    Attributes
    ----------
    scenario : Scenario
    time : ndarray, shape (n,)
        Times of the rows, s: every output interval of the scenario; fewer if the run ended early, none if it did not start.
    columns : mapping of str to ndarray, shape (n,)
        By name, `fmu.variable`, SI; Booleans as 0 and 1.
    metrics : Metrics or None
        What was measured; None if the run did not complete.
    failure : str or None
        Why the run did not complete.
    """

    scenario: Scenario
    time: NDArray[np.float64]
    columns: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    metrics: Metrics | None = None
    failure: str | None = None
