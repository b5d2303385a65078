"""Layouts: starts and goals of the periods of a design point."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rl_design_space.design import DesignPoint
from rl_design_space.learning.checked import places
from rl_design_space.learning.streams import layouts


def layouts_of(point: DesignPoint, periods: int | None = None, number: int = 0) -> NDArray[np.int32]:
    """Return start and goals of each period: (periods, 1 + n_goals) cell numbers, distinct in a row.

    Args:
        point: the design point.
        periods: number of periods, from the first; all if None.
        number: of the layout among those that a period has one after the other.

    Raises:
        ConfigError: the world has too few open cells, or returns them in a wrong form.
    """
    cells = places(point)
    periods = point.task.periods if periods is None else periods
    return cells[layouts(point.seed, len(cells), point.task.goals, periods, number)]
