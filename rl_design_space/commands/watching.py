"""Progress of a report on stderr."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from threading import Lock
from time import monotonic
from typing import TypeVar

Item = TypeVar("Item")

#: Seconds after which a bar appears.
_PATIENCE = 1.0


def watched(items: Sequence[Item], what: str) -> Iterable[Item]:
    """Yield items; in a terminal, show a bar if they take longer than a second."""
    with counting(what, len(items)) as count:
        for item in items:
            yield item
            count()


@contextmanager
def counting(what: str, total: int) -> Iterator[Callable[[], None]]:
    """Yield a function that counts steps; in a terminal, a bar shows them if they take longer than a second.

    Args:
        what: is done in each step.
        total: number of steps.
    """
    begun, bar, done = monotonic(), None, 0
    lock = Lock()  # of threads that read runs

    def count() -> None:
        with lock:
            counted()

    def counted() -> None:
        nonlocal bar, done
        done += 1
        if bar is None and sys.stderr.isatty() and monotonic() - begun > _PATIENCE:
            from rich.console import Console
            from rich.progress import Progress

            bar = Progress(console=Console(stderr=True), transient=True)
            bar.add_task(what, total=total)
            bar.start()
        if bar is not None:
            bar.update(bar.task_ids[0], completed=done)

    try:
        yield count
    finally:
        if bar is not None:
            bar.stop()
