"""Runs are read while others are used: in order, a few at a time, and errors come where they belong."""

from __future__ import annotations

from threading import Barrier

import pytest

from rl_design_space._ahead import ahead


def test_a_few_items_are_read_ahead_in_order():
    begun: list[int] = []

    def read(item: int) -> int:
        begun.append(item)
        return -item

    results = ahead(read, range(100))
    assert [next(results) for _ in range(3)] == [0, -1, -2]
    assert max(begun) < 20
    assert list(results) == [-item for item in range(3, 100)]


def test_an_error_of_reading_comes_in_the_place_of_the_item():
    results = ahead(lambda item: 1 // item, [1, 1, 0, 1])
    assert [next(results), next(results)] == [1, 1]
    with pytest.raises(ZeroDivisionError):
        next(results)


def test_as_many_items_as_there_are_threads_are_read_at_the_same_time():
    together = Barrier(6)

    def read(item: int) -> int:
        together.wait(timeout=10)
        return item

    assert list(ahead(read, range(12), threads=6)) == list(range(12))


def test_after_an_error_no_item_is_begun():
    begun: list[int] = []

    def read(item: int) -> float:
        begun.append(item)
        return 1 / item

    with pytest.raises(ZeroDivisionError):
        list(ahead(read, range(100), threads=1))
    assert len(begun) < 8
