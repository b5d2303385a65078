"""Progress of planning a large sweep."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic

from rich.console import Console
from rich.control import Control
from rich.segment import ControlType

from rl_design_space.commands import terminal

#: Seconds between two messages: in a terminal, where the message is replaced, and elsewhere, where it is a line.
_REPLACED, _LINE = 0.5, 5.0


class PlanningProgress:
    """Prints how many combinations are planned, if planning takes more than a moment.

    Args:
        console: where to print.
        clock: returns the time in seconds.
    """

    def __init__(self, console: Console = terminal.console, clock: Callable[[], float] = monotonic) -> None:
        self._console, self._clock = console, clock
        self._interval = _REPLACED if console.is_terminal else _LINE
        self._printed = clock()
        self._is_shown = False

    def __call__(self, number: int, total: int) -> None:
        """Take note that a combination is about to be planned."""
        last = number == total
        if not last and self._clock() - self._printed < self._interval:
            return
        self._clear()
        if not last:
            self._printed, self._is_shown = self._clock(), True
            text = f"planning: {number:,} of {total:,} combinations"
            self._console.print(text, end="" if self._console.is_terminal else "\n", soft_wrap=True)

    def _clear(self) -> None:
        """Remove the message from a terminal."""
        if self._is_shown and self._console.is_terminal:
            self._console.control(Control((ControlType.CARRIAGE_RETURN,), (ControlType.ERASE_IN_LINE, 2)))
            self._is_shown = False
