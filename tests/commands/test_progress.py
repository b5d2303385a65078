"""Progress of a sweep: plain lines without a terminal, a live display in one."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from rl_design_space.commands.progress import Display
from rl_design_space.commands.terminal import duration
from rl_design_space.design import DesignPoint, Task, Torus
from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.run.runner import Missing
from rl_design_space.tracking.tracker import StoredRun


def point(size: int) -> PlannedPoint:
    made = DesignPoint(world=Torus(size=size), task=Task(periods=2, trials=3))
    return PlannedPoint.of(made, {}, (f"world.size={size}", "msa.lengths=[2]"), ("mine",))


POINTS = [point(size) for size in (4, 5, 6, 7)]
CURVES: LearningCurves = simulate(POINTS[0].point, threads=1)


class Screen:
    """A display on a console that is a terminal or not, and a clock that the test sets."""

    def __init__(self, *, terminal: bool = False, before: int = 0) -> None:
        self.now = 0.0
        self._file = io.StringIO()
        self.console = Console(file=self._file, force_terminal=terminal, width=100, highlight=False, _environ={})
        stored = {planned.fingerprint: StoredRun("run") for planned in POINTS[:before]}
        plan, found = Plan(POINTS, studies=("mine",)), Missing(POINTS[before:], stored)
        self.display = Display(plan, found, "2 threads", console=self.console, clock=lambda: self.now)

    @property
    def text(self) -> str:
        return self._file.getvalue()

    @property
    def lines(self) -> list[str]:
        return self.text.splitlines()

    def run(self, *seconds: float) -> None:
        """Run the last points one after the other, with these durations."""
        for planned, duration_ in zip(POINTS[-len(seconds) :], seconds, strict=True):
            self.display.point_started(planned)
            self.now += duration_
            self.display.point_learned(planned)
            self.display.point_ended(planned, CURVES)


def test_plain_lines_come_every_few_seconds():
    screen = Screen()
    with screen.display:
        screen.run(3, 1, 2, 1)
    assert screen.lines == [
        "mine: 4 of 4 points to run, 2 threads",
        "[3/4] 1.0 points/s, 2.0 s left, 0 failed",
        "[4/4] 1.0 points/s, 0 failed",
    ]


def test_points_that_were_recorded_before_are_counted():
    screen = Screen(before=3)
    with screen.display:
        screen.run(60)
    assert screen.lines == ["mine: 1 of 4 points to run, 2 threads", "[4/4] 0 failed"]


def test_nothing_to_run_shows_nothing():
    screen = Screen(before=4)
    with screen.display:
        pass
    assert screen.text == ""


def test_the_rate_of_slow_points_is_per_minute():
    screen = Screen()
    with screen.display:
        screen.run(30, 30)
    assert "[2/4] 4.0 points/min, 1 min 00 s left" in screen.text


def test_running_points_are_named():
    screen = Screen()
    with screen.display:
        for planned in POINTS:
            screen.display.point_started(planned)
        screen.now += 10
        screen.display.point_learned(POINTS[0])
        screen.display.point_ended(POINTS[0], CURVES)
    assert screen.lines[-1].endswith("; running: world.size=5 msa.lengths=[2] and 2 more")


def test_a_failure_is_shown_at_once_with_its_command():
    screen = Screen()
    with screen.display:
        screen.display.point_started(POINTS[0])
        screen.display.point_ended(POINTS[0], ValueError("no [such] thing"))
        failed, error = screen.lines[1:]
    assert failed == "failed: rl-design-space world.size=4 'msa.lengths=[2]'"
    assert error == "  ValueError: no [such] thing"


@pytest.mark.parametrize(
    ("pending", "problem", "line"),
    [
        (4, "", "recording: 4 results to go, 30.0 results/min, 8.0 s left"),
        (1, "the disk is full", "recording: 1 result to go, 48.0 results/min, 1.2 s left: the disk is full"),
        (9, "", "recording: 9 results to go"),
        (12, "", "recording: 12 results to go"),
    ],
)
def test_the_delivery_is_shown_every_few_seconds(pending: int, problem: str, line: str):
    screen = Screen()
    with screen.display:
        screen.display.delivering(9, "too early to be shown")
        screen.now += 10
        screen.display.delivering(pending, problem)
        screen.display.delivering(pending, problem)
    assert screen.lines[1:] == [line]


def test_points_of_other_processes_are_announced_once():
    screen = Screen()
    with screen.display:
        screen.display.waiting(3)
        screen.now += 10
        for points in (2, 2, 0, 1):
            screen.display.waiting(points)
            screen.now += 3
    assert screen.lines[1:] == [
        f"waiting for {points} that other processes have locked" for points in ("2 points", "1 point")
    ]


def test_a_terminal_shows_a_bar_and_the_running_points():
    screen = Screen(terminal=True)
    with screen.display:
        screen.run(2, 2)
        screen.display.point_started(POINTS[0])
        screen.display._live.refresh()
    assert "mine" in screen.text
    assert "2/4" in screen.text
    assert "world.size=4 msa.lengths=[2]" in screen.text
    assert "0 failed" in screen.text
    # The display is erased at the end.
    assert screen.text.endswith("\x1b[2K") or "\x1b[1A\x1b[2K" in screen.text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.04, "0.0 s"), (3.21, "3.2 s"), (59.4, "59 s"), (61, "1 min 01 s"), (3599, "59 min 59 s"), (7500, "2 h 05 min")],
)
def test_durations_have_units(seconds: float, text: str):
    assert duration(seconds) == text
