"""How likely claims about best values would hold for other values of the grid, drawn at random in their place."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np


class Placebo(NamedTuple):
    """The claimed best values beside values drawn at random.

    Attributes:
        holding: how many of the claimed best values pass their tests.
        best: how many there are.
        chance: probability that at least as many would pass if each was drawn from the other values of its grid.
    """

    holding: int
    best: int
    chance: float


def placebo(tests: Iterable[tuple[bool, int, int]]) -> Placebo | None:
    """Return how the claimed best values compare with values drawn at random; None if there are none.

    The draws are independent, each value of a grid but the claimed one as likely as the others.

    Args:
        tests: of each claimed best value: whether it passes, how many other values of its grid would have passed, and
            how many others there are.
    """
    holding, number = 0, np.ones(1)  # number: the probability of each number of values that pass
    for holds, passing, others in tests:
        holding += holds
        number = np.convolve(number, (1 - passing / others, passing / others))
    best = len(number) - 1
    return Placebo(holding, best, min(1.0, float(number[holding:].sum()))) if best else None
