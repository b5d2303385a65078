"""Learning that several threads can join: how they divide its periods."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rl_design_space.design import Task
from rl_design_space.learning.joint import JointLearning
from rl_design_space.learning.result import LearningCurves


class Listed(JointLearning):
    """A learning that lists its shares.

    Args:
        periods: their number.
        least: how many a thread wants at least.
        joining: threads that join when the first share is taken.
    """

    def __init__(self, periods: int, least: int = 1, joining: int = 0) -> None:
        super().__init__(Task(periods=periods), None)
        self._least, self._joining = least, joining
        self.taken: list[slice] = []

    def _work(self) -> None:
        while (share := self.next_share(self._least)) is not None:
            self.taken.append(share)
            while self._joining:
                self._joining -= 1
                assert not self.work()

    def curves(self) -> LearningCurves:
        raise NotImplementedError


@given(periods=st.integers(1, 60), first=st.integers(0, 59), parts=st.integers(1, 9), least=st.integers(0, 70))
def test_every_period_is_taken_once_in_order(periods: int, first: int, parts: int, least: int):
    first = min(first, periods - 1)
    learning = Listed(periods, least)
    learning.begin(first, lambda left, wanted: max(left // parts, wanted, 1))
    assert learning.has_work
    assert learning.work()
    assert [period for share in learning.taken for period in range(share.start, share.stop)] == [*range(first, periods)]
    assert not learning.has_work
    assert not learning.work()


@pytest.mark.parametrize(("joining", "sizes"), [(0, [100, 100]), (1, [100, 50, 25, 13, 6, 3, 2, 1])])
def test_a_thread_leaves_others_an_even_part_of_what_it_wants(joining: int, sizes: list[int]):
    learning = Listed(200, least=100, joining=joining)
    learning.begin(0, lambda left, wanted: wanted)
    assert learning.work()
    assert [share.stop - share.start for share in learning.taken] == sizes


def test_a_stopped_learning_has_no_work():
    learning = Listed(10)
    learning.begin(0, lambda left, wanted: wanted)
    learning.stop()
    assert not learning.has_work
    assert learning.next_share() is None
