"""Progress of a sweep: a live display in a terminal, plain lines every few seconds elsewhere."""

from __future__ import annotations

from collections import deque
from threading import Lock
from time import monotonic

from rich.console import Group
from rich.live import Live
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
from rich.text import Text

from rl_design_space.commands.terminal import console, duration
from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.cost import expected_moves
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.run.runner import Missing, describe_error
from rl_design_space.tracking.tracker import StoredRun

#: Seconds between two plain lines; points that the rate is taken over; points under way that are named.
_INTERVAL, _RECENT, _NAMED = 5.0, 200, 4
#: Work that every point is, in moves, beside those that it learns: tables, curves, the record.
_OVERHEAD = 5e6


class Display:
    """Shows how far a sweep has come; use it as a context manager around the sweep.

    Args:
        plan: what is run.
        found: what of it is missing.
        workers: who learns, for people.
    """

    def __init__(self, plan: Plan, found: Missing, workers: str) -> None:
        self._name = plan.name
        self._total, self._before = len(plan), len(found.stored)
        self._workers = workers
        self._ended = self._failed = 0
        self._work = self._work_left = sum(_work(planned) for planned in found.points)
        self._under_way: dict[str, str] = {}
        self._settling = ""
        self._times: deque[float] = deque(maxlen=_RECENT)
        self._begun = self._shown = monotonic()
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
        if console.is_terminal:
            self._live.start()
        else:
            self._print(f"{self._name}: {self._total - self._before} of {self._total} points to run, {self._workers}")
        return self

    def __exit__(self, *_: object) -> None:
        if console.is_terminal:
            self._live.stop()

    def started(self, planned: PlannedPoint) -> None:
        """A point is about to be learned."""
        with self._lock:
            self._under_way[planned.fingerprint] = planned.name

    def learned(self, planned: PlannedPoint) -> None:
        """A point waits to be recorded."""
        with self._lock:
            self._under_way.pop(planned.fingerprint, None)

    def ended(self, planned: PlannedPoint, result: LearningCurves | StoredRun | Exception) -> None:
        """A point has been recorded, or has failed, which is shown at once."""
        with self._lock:
            self._ended += 1
            self._work_left -= _work(planned)
            self._times.append(monotonic())
            self._failed += isinstance(result, Exception)
        if isinstance(result, Exception):
            self._print(f"failed: {planned.command}\n  {describe_error(result)}", style="red")
        last = self._before + self._ended == self._total
        if not console.is_terminal and (last or monotonic() - self._shown >= _INTERVAL):
            self._shown = monotonic()
            self._print(f"[{self._before + self._ended}/{self._total}] {self._state()}{self._names()}")

    def waiting(self, left: int, trouble: str) -> None:
        """All is learned; so many records are still to be told to the store, and this is wrong with it, if anything."""
        self._settling = f"writing {left:,} records to the store{f': {trouble}' if trouble else ''}"
        if not console.is_terminal and monotonic() - self._shown >= _INTERVAL:
            self._shown = monotonic()
            self._print(self._settling)

    def _render(self) -> Group:
        self._bar.update(self._task, completed=self._before + self._ended, state=self._state())
        names = list(self._under_way.values())
        lines = [Text(f"  {name}", style="dim", no_wrap=True, overflow="ellipsis") for name in names[:_NAMED]]
        if len(names) > _NAMED:
            lines.append(Text(f"  … and {len(names) - _NAMED} more under way", style="dim"))
        if self._settling:
            lines.append(Text(f"  {self._settling}", style="dim", no_wrap=True, overflow="ellipsis"))
        return Group(self._bar, *lines)

    def _state(self) -> str:
        """Rate, time left and failures."""
        now = monotonic()
        parts = []
        if len(self._times) > 1:
            span = now - self._times[0]
            rate = len(self._times) / span if span else 0.0
            parts.append(f"{rate:.1f} points/s" if rate >= 1 else f"{rate * 60:.1f} points/min")
        if self._ended and self._ended < self._total - self._before:
            left = (now - self._begun) * self._work_left / (self._work - self._work_left)
            parts.append(f"{duration(left)} left")
        parts.append(f"{self._failed} failed")
        return ", ".join(parts)

    def _names(self) -> str:
        """The points under way, in a plain line."""
        names = list(self._under_way.values())
        more = f" and {len(names) - 1} more" if len(names) > 1 else ""
        return f"; now {names[0]}{more}" if names else ""

    def _print(self, text: str, style: str = "") -> None:
        console.print(escape(text), style=style, soft_wrap=True)


def _work(planned: PlannedPoint) -> float:
    return expected_moves(planned.point) + _OVERHEAD
