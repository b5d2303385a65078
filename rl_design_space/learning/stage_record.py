"""What the result of a point says of each of its stages."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class StageRecord(NamedTuple):
    """A stage in the result of a point.

    Attributes:
        trials: number of its trials.
        side: cells along each side of its grid; NaN if it is not square.
        optimum: (periods,) int32, fewest steps possible.
        rows: (periods, 2) int32, see `LearningCurves`.
        carried: (periods,) int32, rows that have begun with values of earlier stages.
    """

    trials: int
    side: float
    optimum: NDArray[np.int32]
    rows: NDArray[np.int32]
    carried: NDArray[np.int32]
