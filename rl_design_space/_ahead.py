"""Computing in threads ahead of where the results are used."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

#: Threads, of which one may hold the interpreter while another one inflates a file.
THREADS = 2
#: Maximum number of results that are held.
_HELD = 8

Item = TypeVar("Item")
Result = TypeVar("Result")


def ahead(function: Callable[[Item], Result], items: Iterable[Item], threads: int = THREADS) -> Iterator[Result]:
    """Yield what a function returns for each item, in the order of the items, some of them ahead.

    Args:
        function: called in a thread.
        items: iterated over in this thread.
        threads: number of threads.
    """
    waiting: deque[Future[Result]] = deque()
    with ThreadPoolExecutor(threads) as pool:
        try:
            for item in items:
                waiting.append(pool.submit(function, item))
                if len(waiting) == _HELD:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for unused in waiting:  # a server that is away lets each of them wait
                unused.cancel()
