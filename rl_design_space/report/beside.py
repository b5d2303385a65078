"""Work in a copy of this process, beside what this one does meanwhile."""

from __future__ import annotations

import sys
import threading
import warnings
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection
from typing import TypeVar

from rl_design_space.learning.cores import available_threads

Result = TypeVar("Result")


def can_be_copied() -> bool:
    """Return whether copies of this process can work: with other threads, a copy may wait for a lock for ever."""
    return sys.platform == "linux" and threading.active_count() == 1


def beside(work: Callable[[], Result]) -> Callable[[], Result]:
    """Begin work in a copy of this process, and return a function that waits for its result.

    Two threads would take as long as one, because Python runs one at a time. A copy needs neither imports nor
    arguments, and only its result is sent. Where there is no core for a copy, or the copy fails, the work is done when
    its result is asked for, which raises the error, if there is one.

    Args:
        work: changes nothing in this process; its result can be pickled.
    """
    # Processes that write the reports of a page leave no core free.
    if available_threads() == 1 or parent_process() is not None or not can_be_copied():
        return work
    receiver, sender = get_context("fork").Pipe(duplex=False)
    process = get_context("fork").Process(target=_send, args=(work, sender), daemon=True)
    with warnings.catch_warnings():
        # Newer versions of Python warn of any thread, such as those of linear algebra, which copies do without.
        warnings.simplefilter("ignore", DeprecationWarning)
        process.start()
    sender.close()

    def result() -> Result:
        with receiver:
            try:
                found: Result = receiver.recv()
            except EOFError:
                return work()
        process.join()
        return found

    return result


def _send(work: Callable[[], Result], sender: Connection) -> None:
    with suppress(Exception, KeyboardInterrupt):
        sender.send(work())
