"""Reading runs while others are used."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

#: Threads, of which one can inflate files while another one computes; and results that are held in memory at most.
_THREADS, _HELD = 2, 8

Item = TypeVar("Item")
Result = TypeVar("Result")


def read_ahead(read: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """Yield what is read for each item, in this order.

    Args:
        read: reads one item, in a thread.
        items: the items.
    """
    waiting: deque[Future[Result]] = deque()
    with ThreadPoolExecutor(_THREADS) as pool:
        for item in items:
            waiting.append(pool.submit(read, item))
            if len(waiting) == _HELD:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
