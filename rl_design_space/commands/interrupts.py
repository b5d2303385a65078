"""How a command ends: the first Ctrl-C or SIGTERM ends it in good order, a later one at once."""

from __future__ import annotations

import atexit
import gc
import os
import signal
from collections.abc import Callable
from time import monotonic
from types import FrameType

#: What running an interrupted command again is for.
CONTINUE = "to continue"
#: Exit status of a command that was interrupted.
INTERRUPTED = 130
#: Seconds in which all interrupts count as one: impatient people press Ctrl-C several times.
_ONE = 2.0


class Interrupts:
    """A signal handler that raises KeyboardInterrupt, once.

    Interrupts that follow at once are ignored, so that none of them breaks into what the first one ends. A later one
    ends the process where it is, which costs nothing: results are on disk, and the next command continues.

    Args:
        clock: returns the time in seconds.
        end: ends the process with a status.
        purpose: of running the command again.
    """

    def __init__(
        self,
        clock: Callable[[], float] = monotonic,
        end: Callable[[int], object] = os._exit,
        purpose: str = CONTINUE,
    ) -> None:
        self._clock, self._end, self._purpose = clock, end, purpose
        self._first: float | None = None

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal.

        Raises:
            KeyboardInterrupt: it is the first one.
        """
        if self._first is None:
            self._first = self._clock()
            raise KeyboardInterrupt
        if self._clock() - self._first > _ONE:
            os.write(2, f"interrupted again: ended at once; run the same command again {self._purpose}\n".encode())
            self._end(INTERRUPTED)


def handle_interrupts(purpose: str = CONTINUE) -> None:
    """Handle SIGINT, unless it is ignored as in the background of a shell, and SIGTERM, which batch systems send.

    Args:
        purpose: of running the command again.
    """
    handler = Interrupts(purpose=purpose)
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, handler)
    signal.signal(signal.SIGTERM, handler)


def end_quickly() -> None:
    """Leave all memory to the operating system when the process ends, in which Python looks for garbage otherwise.

    That takes 0.2 to 0.6 s, after everything is done and printed: imports make hundreds of thousands of objects.
    """
    atexit.register(gc.freeze)
