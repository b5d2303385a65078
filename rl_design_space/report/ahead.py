"""Computing in threads ahead of where the results are used."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

#: Threads, of which one may hold the interpreter while another one inflates a file; and results that are held at most.
_THREADS, _HELD = 2, 8

Item = TypeVar("Item")
Result = TypeVar("Result")


def ahead(function: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """Yield what a function returns for each item, in the order of the items, some of them ahead.

    Args:
        function: called in a thread.
        items: iterated over in this thread.
    """
    waiting: deque[Future[Result]] = deque()
    with ThreadPoolExecutor(_THREADS) as pool:
        for item in items:
            waiting.append(pool.submit(function, item))
            if len(waiting) == _HELD:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
