"""Has a spool delivered by a process of its own, and watches over it."""

from __future__ import annotations

import atexit
import json
import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from threading import Condition, Thread
from time import monotonic, time_ns

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.pace import CALM, HURRY
from rl_design_space.tracking.spool import Spool

#: Seconds between two looks, the second if there is much to look at; that a tracker process gets to end what it is at;
#: and that leaving may take when there is nothing wrong.
_GLANCE, _LONG_GLANCE, _ENDING, _LEAVING = 0.05, 0.5, 10.0, 3.0
#: Seconds without any delivery after which something must be wrong: to create a database takes 20 on a slow machine.
_QUIET = 120.0
#: Seconds in which a tracker process that is waited for should have opened its store. Where others want all cores, the
#: lowest priority would take it minutes, and cannot be raised: then it is replaced by one that never held back.
_OPENING = 5.0
#: How many waiting records are much.
_MANY = 100
#: Tracker processes that may die one after the other without having delivered anything.
_DEATHS = 3


@dataclass
class Left:
    """What came of records when no more was to be waited for.

    Attributes:
        awaiting: how many are not in the store yet.
        why: what kept them.
        aside: why records were set aside, by their names.
    """

    awaiting: int = 0
    why: str = ""
    aside: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class _Waiting:
    """A record that waits: what to call when it does no more, and since when it does (nanoseconds since 1970)."""

    done: Callable[[], None]
    since: int = field(default_factory=time_ns)


class Courier:
    """Starts the tracker process of a spool when there is something to deliver, and again if it dies.

    Args:
        spool: whose records this process cares for: those that it writes, and those it finds.
    """

    def __init__(self, spool: Spool) -> None:
        self._spool = spool
        self._changed = Condition()
        self._waiting: dict[str, _Waiting] = dict.fromkeys(spool.waiting(), _Waiting(_nothing))
        self._aside: dict[str, str] = {}
        self._process: subprocess.Popen[bytes] | None = None
        self._thread: Thread | None = None
        self._deaths = 0
        self._trouble = self._unusable = ""
        self._leaving = self._hurry = False
        #: Of the tracker process: its first pace and that of now, since when, and whether its store is open.
        self._first = self._pace = CALM
        self._since = monotonic()
        self._open = False
        #: When something was delivered last, or began to wait for it.
        self._moved = monotonic()

    @property
    def left(self) -> int:
        """Records that are not in the store yet."""
        return len(self._waiting)

    def watch(self, name: str, done: Callable[[], None]) -> None:
        """Have a record that has just been written delivered.

        Args:
            name: of the record.
            done: is called when the store has it, or it was set aside; in a thread of the courier's.

        Raises:
            ConfigError: the store is of no use.
        """
        with self._changed:
            if not self._waiting:
                self._moved = monotonic()
            self._waiting[name] = _Waiting(done)
            self._aside.pop(name, None)  # of an earlier record of the same point
        self.wake()

    def wake(self) -> None:
        """See to it that a tracker process is there.

        Raises:
            ConfigError: the store is of no use.
        """
        self._raise_unusable()
        with self._changed:
            if self._thread is None:
                self._moved = monotonic()
                self._thread = Thread(target=self._run, name="courier", daemon=True)
                self._thread.start()
                atexit.register(self.leave)

    def settle(self, patience: float, told: Callable[[int, str], None] = lambda left, trouble: None) -> Left:
        """Wait until every record is delivered, or nothing has been for too long.

        Args:
            patience: seconds without any delivery after which to give up, if something is wrong.
            told: is called now and then with the number of records left and what is wrong, if anything.

        Raises:
            ConfigError: the store is of no use.
        """
        if self._waiting:
            self.wake()
        with self._changed:
            self._hurry = True
            while self._waiting and not self._unusable and monotonic() - self._moved < self._limit(patience):
                told(len(self._waiting), self._trouble)
                self._changed.wait(_GLANCE)
            aside, self._aside = self._aside, {}
            self._hurry = False
            left = Left(len(self._waiting), self._trouble, aside)
        self._raise_unusable()
        if left.awaiting and not left.why:
            left.why = f"nothing was delivered for {self._limit(patience):.0f} s"
        return left

    def _limit(self, patience: float) -> float:
        """Seconds without any delivery after which to give up: more while nothing is known to be wrong."""
        return patience if self._trouble else max(patience, _QUIET)

    def leave(self) -> None:
        """End the tracker process, which may end what it is at; give it a moment for the rest if nothing is wrong."""
        atexit.unregister(self.leave)
        until = monotonic() + _LEAVING
        with self._changed:
            self._hurry = True
            while self._thread and self._waiting and not (self._trouble or self._unusable) and monotonic() < until:
                self._changed.wait(_GLANCE)
            self._leaving = True
            self._changed.notify_all()
        if self._thread:
            self._thread.join()

    def _run(self) -> None:
        while not self._leaving and not self._unusable:
            self._set_pace()
            if self._starves:
                self._end_process(grace=0)
            self._see_to_process()
            self._listen()
            self._look()
            with self._changed:
                self._changed.wait_for(lambda: self._leaving, _LONG_GLANCE if len(self._waiting) > _MANY else _GLANCE)
        self._end_process()
        self._look()

    def _see_to_process(self) -> None:
        if self._process and self._process.poll() is None:
            return
        if self._process:
            self._listen()
            self._deaths += 1
            with suppress(OSError):
                self._process.stdin.close()  # type: ignore[union-attr]
        if self._deaths > _DEATHS:
            self._trouble = f"the tracker process dies; its last words are in {self._log}"
            return
        self._first = self._pace = HURRY if self._hurry else CALM
        self._open = False
        with self._log.open("ab") as log:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "rl_design_space.tracking.process", str(self._spool.folder), self._pace],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
            )
        os.set_blocking(self._process.stdout.fileno(), False)  # type: ignore[union-attr]

    def _set_pace(self) -> None:
        """Have the tracker process hold back while this one learns, and hurry while it is waited for."""
        pace = HURRY if self._hurry else CALM
        if self._process and self._pace != pace:
            self._pace, self._since = pace, monotonic()
            with suppress(OSError, ValueError):  # it has died
                self._process.stdin.write(f"{pace}\n".encode())  # type: ignore[union-attr]
                self._process.stdin.flush()  # type: ignore[union-attr]

    @property
    def _starves(self) -> bool:
        """Whether the tracker process is waited for, and others keep it from opening the store."""
        opening = not (self._open or self._trouble)
        return opening and (self._first, self._pace) == (CALM, HURRY) and monotonic() - self._since > _OPENING

    def _listen(self) -> None:
        if self._process is None:
            return
        for line in self._process.stdout or ():
            with suppress(ValueError):  # of half a line
                message = json.loads(line)
                self._unusable = message.get("unusable", self._unusable)
                self._open = self._open or message.get("trouble", "") is None
                self._trouble = message.get("trouble", self._trouble) or ""
        with self._changed:
            self._changed.notify_all()

    def _look(self) -> None:
        """Notice what has been delivered, by whomever."""
        with self._changed:
            known = dict(self._waiting)
        there = set(self._spool.waiting())
        with self._changed:
            # What is written while the folder is read may be missing from its list.
            gone = {
                name: waiting
                for name, waiting in known.items()
                if name not in there and self._waiting.get(name) is waiting
            }
            for name, waiting in gone.items():
                del self._waiting[name]
                if why := self._spool.why_aside(name, waiting.since):
                    self._aside[name] = why
            if gone:
                self._moved = monotonic()
                self._deaths = 0
                self._changed.notify_all()
        for waiting in gone.values():
            waiting.done()

    def _end_process(self, grace: float = _ENDING) -> None:
        if self._process is None:
            return
        with suppress(OSError):
            self._process.stdin.close()  # type: ignore[union-attr]
        try:
            self._process.wait(grace)
        except subprocess.TimeoutExpired:
            # It is held up by the store. What it has begun is gone on with the next time.
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()  # type: ignore[union-attr]
        self._process = None

    @property
    def _log(self) -> Path:
        return self._spool.folder / "tracker.log"

    def _raise_unusable(self) -> None:
        if self._unusable:
            raise ConfigError(self._unusable)


@cache
def courier_of(folder: Path) -> Courier:
    """The courier of this process for a spool."""
    return Courier(Spool(folder))


def _nothing() -> None:
    pass
