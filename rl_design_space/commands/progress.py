"""Progress of a sweep: a live display in a terminal, plain lines every few seconds elsewhere."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Lock
from time import monotonic

from rich.console import Console, Group
from rich.live import Live
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
from rich.text import Text

from rl_design_space.commands import terminal
from rl_design_space.commands.terminal import counted, duration
from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.run.outcome import describe_error
from rl_design_space.run.runner import Missing
from rl_design_space.tracking.tracker import StoredRun

#: Seconds between two plain lines; number of points that the rate is computed from; number of running points listed.
_INTERVAL, _RECENT, _LISTED = 5.0, 200, 4
#: Cost of a point beside its learning (tables, curves, record), in steps.
_OVERHEAD = 5e6


class Display:
    """Shows the progress of a sweep; a context manager around the sweep, and its `SweepMonitor`.

    Args:
        plan: the points of the sweep.
        found: which of them have no run yet.
        workers: description of the executor.
        console: where to print.
        clock: returns the time in seconds.
    """

    def __init__(
        self,
        plan: Plan,
        found: Missing,
        workers: str,
        *,
        console: Console = terminal.console,
        clock: Callable[[], float] = monotonic,
    ) -> None:
        self._name = plan.name
        self._total, self._before = len(plan), len(found.stored)
        self._workers = workers
        self._console, self._clock = console, clock
        self._ended = self._failed = 0
        self._works = {planned.fingerprint: found.steps_left(planned) + _OVERHEAD for planned in found.points}
        self._work = self._work_left = sum(self._works.values())
        self._running: dict[str, str] = {}
        self._delivery = ""
        self._waiting = self._told = 0
        self._times: deque[float] = deque(maxlen=_RECENT)
        #: Moments, and how many results were not in the store yet.
        self._pending: deque[tuple[float, int]] = deque(maxlen=_RECENT)
        self._begun = self._shown = clock()
        self._lock = Lock()
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[state]}"),
        )
        self._bar = Progress(*columns, console=console)
        self._task = self._bar.add_task(escape(self._name), total=self._total, completed=self._before, state="")
        self._live = Live(get_renderable=self._render, console=console, transient=True, refresh_per_second=4)

    def __enter__(self) -> Display:
        if self._before == self._total:
            return self
        if self._console.is_terminal:
            self._live.start()
        else:
            self._print(f"{self._name}: {self._total - self._before} of {self._total} points to run, {self._workers}")
        return self

    def __exit__(self, *_: object) -> None:
        if self._console.is_terminal:
            self._live.stop()

    def point_started(self, planned: PlannedPoint) -> None:
        """Add a point to the running ones."""
        with self._lock:
            self._running[planned.fingerprint] = planned.name

    def point_learned(self, planned: PlannedPoint) -> None:
        """Remove a point from the running ones; it is not recorded yet."""
        with self._lock:
            self._running.pop(planned.fingerprint, None)

    def point_ended(self, planned: PlannedPoint, result: LearningCurves | StoredRun | Exception) -> None:
        """Count a recorded or failed point; print an error at once."""
        with self._lock:
            self._ended += 1
            self._work_left -= self._works[planned.fingerprint]
            self._times.append(self._clock())
            self._failed += isinstance(result, Exception)
        if isinstance(result, Exception):
            self._print(f"failed: {planned.command}\n  {describe_error(result)}", style="red")
        last = self._before + self._ended == self._total
        if not self._console.is_terminal and (last or self._is_due()):
            self._shown = self._clock()
            self._print(f"[{self._before + self._ended}/{self._total}] {self._state()}{self._names()}")

    def waiting(self, points: int) -> None:
        """Show the number of points that only other processes are working on, if it is another one than before."""
        self._waiting = points
        if points not in (0, self._told) and not self._running and not self._console.is_terminal and self._is_due():
            self._shown, self._told = self._clock(), points
            self._print(self._waits())

    def delivering(self, pending: int, problem: str) -> None:
        """Show how many results are not in the store yet, how fast they get there, and what is wrong, if anything."""
        now = self._clock()
        if not self._pending or pending > self._pending[-1][1]:
            self._pending.clear()
        self._pending.append((now, pending))
        since, before = self._pending[0]
        parts = [f"recording: {counted(pending, 'result')} to go"]
        if now > since and before > pending:
            rate = (before - pending) / (now - since)
            parts += [_rate(rate, "results"), f"{duration(pending / rate)} left"]
        self._delivery = f"{', '.join(parts)}{f': {problem}' if problem else ''}"
        if not self._console.is_terminal and self._is_due():
            self._shown = self._clock()
            self._print(self._delivery)

    def _is_due(self) -> bool:
        return self._clock() - self._shown >= _INTERVAL

    def _render(self) -> Group:
        self._bar.update(self._task, completed=self._before + self._ended, state=self._state())
        names = list(self._running.values())
        lines = [Text(f"  {name}", style="dim", no_wrap=True, overflow="ellipsis") for name in names[:_LISTED]]
        if len(names) > _LISTED:
            lines.append(Text(f"  … and {len(names) - _LISTED} more running", style="dim"))
        if self._waiting:
            lines.append(Text(f"  {self._waits()}", style="dim", no_wrap=True, overflow="ellipsis"))
        if self._delivery:
            lines.append(Text(f"  {self._delivery}", style="dim", no_wrap=True, overflow="ellipsis"))
        return Group(self._bar, *lines)

    def _state(self) -> str:
        """Return the rate, the time left and the number of failures."""
        now = self._clock()
        parts = []
        if len(self._times) > 1:
            span = now - self._times[0]
            rate = len(self._times) / span if span else 0.0
            parts.append(_rate(rate, "points"))
        if self._ended and self._ended < self._total - self._before:
            left = (now - self._begun) * self._work_left / (self._work - self._work_left)
            parts.append(f"{duration(left)} left")
        parts.append(f"{self._failed} failed")
        return ", ".join(parts)

    def _waits(self) -> str:
        return f"waiting for {counted(self._waiting, 'point')} that other processes have locked"

    def _names(self) -> str:
        """Return the running points, as the end of a plain line."""
        names = list(self._running.values())
        more = f" and {len(names) - 1} more" if len(names) > 1 else ""
        return f"; running: {names[0]}{more}" if names else ""

    def _print(self, text: str, style: str = "") -> None:
        self._console.print(escape(text), style=style, soft_wrap=True)


def _rate(a_second: float, what: str) -> str:
    return f"{a_second:.1f} {what}/s" if a_second >= 1 else f"{a_second * 60:.1f} {what}/min"
