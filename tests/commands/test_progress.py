"""What a sweep shows: plain lines where nobody watches, a live display where somebody does."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from rl_design_space.commands import progress
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
Clock = list[float]


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """Time passes when the test says so."""
    now = [0.0]
    monkeypatch.setattr(progress, "monotonic", lambda: now[0])
    return now


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch):
    """A console that is no terminal, or one that is."""

    def make(terminal: bool) -> io.StringIO:
        written = io.StringIO()
        console = Console(file=written, force_terminal=terminal, width=100, highlight=False, _environ={})
        monkeypatch.setattr(progress, "console", console)
        return written

    return make


def display(before: int = 0) -> Display:
    stored = {planned.fingerprint: StoredRun("run") for planned in POINTS[:before]}
    return Display(Plan(POINTS, studies=("mine",)), Missing(POINTS[before:], stored), "2 threads")


def run(shows: Display, clock: Clock, *seconds: float) -> None:
    """Each point takes so many seconds, one after the other."""
    for planned, took in zip(POINTS[-len(seconds) :], seconds, strict=True):
        shows.started(planned)
        clock[0] += took
        shows.learned(planned)
        shows.ended(planned, CURVES)


def test_plain_lines_come_every_few_seconds(shown, clock: Clock):
    written = shown(terminal=False)
    with display() as shows:
        run(shows, clock, 3, 1, 2, 1)
    assert written.getvalue().splitlines() == [
        "mine: 4 of 4 points to run, 2 threads",
        "[3/4] 1.0 points/s, 2.0 s left, 0 failed",
        "[4/4] 1.0 points/s, 0 failed",
    ]


def test_points_that_were_there_before_count(shown, clock: Clock):
    written = shown(terminal=False)
    with display(before=3) as shows:
        run(shows, clock, 60)
    assert written.getvalue().splitlines() == ["mine: 1 of 4 points to run, 2 threads", "[4/4] 0 failed"]


def test_nothing_to_run_shows_nothing(shown, clock: Clock):
    written = shown(terminal=False)
    with display(before=4):
        pass
    assert written.getvalue() == ""


def test_slow_points_are_counted_by_the_minute(shown, clock: Clock):
    written = shown(terminal=False)
    with display() as shows:
        run(shows, clock, 30, 30)
    assert "[2/4] 4.0 points/min, 1 min 00 s left" in written.getvalue()


def test_what_is_under_way_is_named(shown, clock: Clock):
    written = shown(terminal=False)
    with display() as shows:
        for planned in POINTS:
            shows.started(planned)
        clock[0] += 10
        shows.learned(POINTS[0])
        shows.ended(POINTS[0], CURVES)
    assert written.getvalue().splitlines()[-1].endswith("; now world.size=5 msa.lengths=[2] and 2 more")


def test_a_failure_is_shown_at_once_with_its_command(shown, clock: Clock):
    written = shown(terminal=False)
    with display() as shows:
        shows.started(POINTS[0])
        shows.ended(POINTS[0], ValueError("no [such] thing"))
        failed, error = written.getvalue().splitlines()[1:]
    assert failed == "failed: rl-design-space world.size=4 'msa.lengths=[2]'"
    assert error == "  ValueError: no [such] thing"


def test_a_terminal_shows_a_bar_and_what_runs(shown, clock: Clock):
    written = shown(terminal=True)
    shows = display()
    with shows:
        run(shows, clock, 2, 2)
        shows.started(POINTS[0])
        shows._live.refresh()
    text = written.getvalue()
    assert "mine" in text
    assert "2/4" in text
    assert "world.size=4 msa.lengths=[2]" in text
    assert "0 failed" in text
    # Nothing of it stays.
    assert text.endswith("\x1b[2K") or "\x1b[1A\x1b[2K" in text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.04, "0.0 s"), (3.21, "3.2 s"), (59.4, "59 s"), (61, "1 min 01 s"), (3599, "59 min 59 s"), (7500, "2 h 05 min")],
)
def test_time_spans_are_for_people(seconds: float, text: str):
    assert duration(seconds) == text
