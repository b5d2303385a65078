"""What actions that follow a table do at an observation, as numbers.

A *control* has 32 bits: the step that the action makes there, whether it stops on arriving there, and the number of its
*mark*, which is what the agent perceives.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

#: Bits of a control: the step, 0 to 3 as in the transition table or 4 to wait; whether the action stops; the mark.
STEP, STOP, MARK = 7, 8, 0xFFFFFFF0


class ActionTable(NamedTuple):
    """What actions do in some periods.

    Attributes:
        controls: (periods, n_goals · cells, n_actions) uint8, by success counter and cell: the step that the action
            makes there, plus `STOP` where it stops on arriving.
        marks: (periods, n_goals · cells) int64, what the agent perceives: actions end where it changes.
    """

    controls: NDArray[np.uint8]
    marks: NDArray[np.int64]


def no_table(observations: int, n_actions: int) -> ActionTable:
    """Return the table of no periods."""
    controls = np.empty((0, observations, n_actions), dtype=np.uint8)
    return ActionTable(controls, np.empty((0, observations), dtype=np.int64))
