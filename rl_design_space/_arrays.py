"""The array types that most tables have."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.integer[Any]]
FloatArray = NDArray[np.float64]
#: Fewest steps; float64 if they are expected ones, in a stochastic world.
Optimum = NDArray[np.int32] | FloatArray
