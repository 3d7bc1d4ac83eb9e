"""Types of arrays of numbers; docstrings have their shapes."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Bools = NDArray[np.bool_]
Texts = NDArray[np.str_]
