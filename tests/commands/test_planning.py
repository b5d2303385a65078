"""Progress of planning: a message that is replaced in a terminal, lines elsewhere, nothing if it is quick."""

from __future__ import annotations

from io import StringIO

import pytest
from rich.console import Console

from rl_design_space.commands.planning import PlanningProgress


@pytest.mark.parametrize(
    ("seconds_each", "terminal", "expected"),
    [
        (0.001, False, ""),
        (0.001, True, ""),
        (2.0, False, "planning: 3 of 7 combinations\nplanning: 6 of 7 combinations\n"),
        (0.3, True, "\r\x1b[2Kplanning: 4 of 7 combinations"),
    ],
)
def test_planning_is_shown_if_it_takes_long(seconds_each: float, terminal: bool, expected: str):
    written, now = StringIO(), iter(range(100))
    progress = PlanningProgress(
        Console(file=written, force_terminal=terminal, width=80, highlight=False),
        clock=lambda: next(now) * seconds_each,
    )
    for number in range(1, 8):
        progress(number, 7)
    assert expected in written.getvalue()
    assert bool(expected) == bool(written.getvalue())
    if terminal and expected:
        assert written.getvalue().endswith("\r\x1b[2K")
