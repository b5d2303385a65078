"""Total steps of real periods of direction cells of Table 4: 50,000 periods of each, k = 0.02, seed 2³¹.

The file holds the steps from one period to the next in ascending order, see `stored`.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

FILE = Path(__file__).parent / "data" / "heavy_tails.npz"


@cache
def periods(cell: str) -> np.ndarray:
    """Return the total steps of each period of a cell: goals that are observed, size, number of goals."""
    with np.load(FILE) as arrays:
        return arrays[cell].cumsum(dtype=np.float64)


def stored(total_steps: np.ndarray) -> np.ndarray:
    """Return total steps as the file holds them."""
    return np.diff(np.sort(total_steps).astype(np.uint32), prepend=np.uint32(0))
