"""How failed trials end, on paths made by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from rl_design_space.analysis.endings import (
    CIRCLE,
    CIRCLE_IN_ONE,
    NOT_LEARNED,
    NOT_REPRESENTED,
    OPEN,
    WANDERING,
    WANDERING_IN_ONE,
    ending,
    verdict,
)
from rl_design_space.learning.memoryless import Memoryless
from rl_design_space.learning.sequential.method import Path

#: Cells 0 to 2 look the same, and so do 3 to 5.
ROW = np.array([[0, 0, 0, 1, 1, 1], [2, 2, 2, 3, 3, 3]], dtype=np.int32)


def ended(cells: list[int], counter: int = 0, last: int = 1000):
    counters = np.full(len(cells), counter, dtype=np.int32)
    path = Path(np.array(cells, dtype=np.int32), counters, counters[1:], counters[1:] > 0)
    return ending(SimpleNamespace(paths=(path,), row=ROW), 0, last)


@pytest.mark.parametrize(
    ("cells", "kind", "circle"),
    [
        ([5, 4, *[0, 1, 2, 1] * 6], CIRCLE, 0),
        ([*[0, 1, 2, 1] * 6], CIRCLE_IN_ONE, 4),
        ([*[0, 1] * 6, 0], CIRCLE_IN_ONE, 2),
        ([*[0, 3, 4] * 6], CIRCLE, 3),
        ([0, 1, 2, 0, 2, 1, 0, 0, 1], WANDERING_IN_ONE, 0),
        ([0, 1, 4, 0, 2, 3, 0, 0, 1], WANDERING, 0),
        ([0, 0, 0, 0, 0], CIRCLE_IN_ONE, 1),
    ],
)
def test_circles_are_found_and_told_from_wandering(cells: list[int], kind: str, circle: int):
    found = ended(cells)
    if circle == 0 and kind == CIRCLE:  # the circle has a beginning, which is not within the steps looked at
        assert ended(cells, last=16).kind == CIRCLE_IN_ONE
        assert found.kind == WANDERING
        return
    assert (found.kind, found.circle) == (kind, circle)


def test_the_observation_is_the_most_frequent_one_of_its_counter():
    found = ended([5, 4, 1, 2, 2], counter=1)
    assert (found.reached, found.row, found.share, found.observations) == (1, 2, 0.6, 2)
    assert found.stays == 0.75


def test_a_verdict_needs_a_policy_or_a_proof():
    assert verdict(Memoryless(12, 10, 100)) == NOT_LEARNED
    assert verdict(Memoryless(None, 101, 100)) == NOT_REPRESENTED
    assert verdict(Memoryless(None, 10, 100)) == OPEN
