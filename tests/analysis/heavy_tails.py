"""Total steps of real periods of cells of Table 4 with a heavy tail: 50,000 periods of each, seed 2³¹, k = 0.02.

`python -m docs.coverage --store` learns them again.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

FILE = Path(__file__).parent / "data" / "heavy_tails.npz"
#: Cells: goals that a direction observes, size, number of goals.
CELLS = {"remaining_10_2": ("remaining", 10, 2), "remaining_10_3": ("remaining", 10, 3), "all_10_2": ("all", 10, 2)}


@cache
def periods(cell: str) -> np.ndarray:
    """Return the total steps of each period, in ascending order; stored as the steps from one to the next."""
    with np.load(FILE) as arrays:
        return arrays[cell].cumsum(dtype=np.float64)


def store(learned: dict[str, np.ndarray]) -> None:
    """Write periods as `periods` reads them."""
    steps = {cell: np.diff(np.sort(values).astype(np.uint32), prepend=np.uint32(0)) for cell, values in learned.items()}
    np.savez_compressed(FILE, **steps)
