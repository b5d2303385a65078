"""Delivery in the background: a tracker process is kept running while there are pending records."""

from __future__ import annotations

import atexit
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from threading import Condition, Thread
from time import monotonic, time_ns

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.spool import Spool, is_point, key_of
from rl_design_space.tracking.tracker import DeliveryStatus
from rl_design_space.tracking.tracker_process import BACKGROUND, FOREGROUND, TrackerProcess

#: Seconds between two looks into the spool, the second if it holds more than so many records.
_POLL, _LONG_POLL, _MANY = 0.05, 0.5, 100
#: Number of tracker processes in a row that may die without having delivered anything.
_DEATHS = 3


@dataclass(frozen=True)
class Timeouts:
    """Limits of waiting, in seconds.

    Attributes:
        silence: without any delivery although no problem is known: creating a database takes 20 on a slow machine.
        connecting: for a tracker process to import MLflow and to reach a server.
        opening: for a tracker process to open the store in the foreground before it is replaced.
        leaving: for the remaining records when this process ends.
        ending: for a tracker process to finish its current record.
    """

    silence: float = 120.0
    connecting: float = 30.0
    opening: float = 5.0
    leaving: float = 3.0
    ending: float = 10.0


@dataclass(frozen=True)
class _Pending:
    """A pending record.

    Attributes:
        on_delivery: called when it is pending no more.
        since: when it was written or found; nanoseconds since 1970.
    """

    on_delivery: Callable[[], None]
    since: int = field(default_factory=time_ns)


class BackgroundDelivery:
    """Starts the tracker process of a spool when there is something to deliver, and restarts it if it dies.

    A thread polls the spool: a record whose file is gone has been delivered, by whatever process, or quarantined.

    Args:
        spool: whose records are watched: those that are there, and those that this process will write.
        timeouts: limits of waiting.
    """

    def __init__(self, spool: Spool, timeouts: Timeouts = Timeouts()) -> None:
        self._spool = spool
        self._timeouts = timeouts
        self._log = spool.folder / "tracker.log"
        self._is_server = spool.address.is_server
        #: Guards all that follows, and is notified when records have been delivered.
        self._changed = Condition()
        self._pending: dict[str, _Pending] = dict.fromkeys(spool.pending(), _Pending(_nothing))
        self._lost: dict[str, str] = {}
        self._problem = self._unusable = ""
        self._waited_for = self._leaving = False
        #: Whether a tracker process has opened the store.
        self._is_open = False
        #: When something was delivered last, or the oldest pending record was written.
        self._last_progress = monotonic()
        #: Used by the thread alone.
        self._process: TrackerProcess | None = None
        self._deaths = 0
        self._thread: Thread | None = None

    @property
    def pending(self) -> int:
        """Number of pending records."""
        return len(self._pending)

    def watch(self, name: str, on_delivery: Callable[[], None]) -> None:
        """Deliver a record that has just been written.

        Args:
            name: of the record.
            on_delivery: called in another thread when the record is delivered or quarantined.

        Raises:
            ConfigError: the store cannot be used.
        """
        with self._changed:
            if not self._pending:
                self._last_progress = monotonic()
            self._pending[name] = _Pending(on_delivery)
            self._lost.pop(key_of(name), None)  # of an earlier record of the same point
        self.start()

    def start(self) -> None:
        """Start delivery unless it runs already.

        Raises:
            ConfigError: the store cannot be used.
        """
        self._raise_unusable()
        with self._changed:
            if self._thread is None:
                self._last_progress = monotonic()
                self._thread = Thread(target=self._run, name="background delivery", daemon=True)
                self._thread.start()
                atexit.register(self.leave)

    def wait(
        self, patience: float, on_progress: Callable[[int, str], None] = lambda pending, problem: None
    ) -> DeliveryStatus:
        """Wait until no record is pending; give up when nothing was delivered for too long.

        Args:
            patience: seconds without any delivery after which to give up if there is a problem.
            on_progress: called every now and then with the number of pending records and the current problem, which is
                empty if there is none.

        Returns:
            The status; `lost` are points whose records were quarantined since the last call.

        Raises:
            ConfigError: the store cannot be used.
        """
        if self._pending:
            self.start()
        with self._changed:
            self._waited_for = True
            while self._pending and not self._unusable and monotonic() - self._last_progress < self._limit(patience):
                on_progress(len(self._pending), self._problem)
                self._changed.wait(_POLL)
            self._waited_for = False
            lost, self._lost = self._lost, {}
            status = DeliveryStatus(len(self._pending), self._problem, lost)
        self._raise_unusable()
        if status.pending and not status.reason:
            status.reason = f"nothing was delivered for {self._limit(patience):.0f} s"
        return status

    def leave(self) -> None:
        """End the tracker process; give it a moment to deliver the rest if nothing is wrong."""
        atexit.unregister(self.leave)
        until = monotonic() + self._timeouts.leaving
        with self._changed:
            self._waited_for = True
            while self._thread and self._pending and not (self._problem or self._unusable) and monotonic() < until:
                self._changed.wait(_POLL)
            self._leaving = True
            self._changed.notify_all()
        if self._thread:
            self._thread.join()

    def _limit(self, patience: float) -> float:
        """Return the seconds without any delivery after which to give up; more while no problem is known."""
        if self._problem:
            return patience
        if self._is_server:
            return patience if self._is_open else max(patience, self._timeouts.connecting)
        return max(patience, self._timeouts.silence)

    def _run(self) -> None:
        while not self._leaving and not self._unusable:
            self._note_messages()  # first, so that a process that has just opened the store is not taken for starved
            self._keep_process()
            self._note_deliveries()
            with self._changed:
                self._changed.wait_for(lambda: self._leaving, _LONG_POLL if len(self._pending) > _MANY else _POLL)
        if self._process:
            self._process.end(self._timeouts.ending)
        self._note_deliveries()

    def _keep_process(self) -> None:
        """Have a tracker process running at the right priority."""
        priority = FOREGROUND if self._waited_for else BACKGROUND
        if self._process:
            self._process.set_priority(priority)
            if not self._process.is_starved(self._timeouts.opening):
                if self._process.is_alive:
                    return
                self._note_messages()
                self._deaths += 1
            self._process.end(grace=0)
            self._process = None
        if self._unusable:
            return
        if self._deaths > _DEATHS:
            self._problem = f"the tracker process keeps dying; see {self._log}"
        else:
            self._process = TrackerProcess(self._spool.folder, priority, self._log)

    def _note_messages(self) -> None:
        if self._process is None:
            return
        self._process.read_messages()
        with self._changed:
            if self._process.problem is not None:
                self._problem = self._process.problem
                self._is_open = self._is_open or not self._problem
            self._unusable = self._process.unusable or self._unusable
            self._changed.notify_all()

    def _note_deliveries(self) -> None:
        """Compare the folder with the records that were pending before it was read."""
        with self._changed:
            known = dict(self._pending)
        present = set(self._spool.pending())
        with self._changed:
            # A record that was written while the folder was read may be missing from its list.
            gone = {
                name: record
                for name, record in known.items()
                if name not in present and self._pending.get(name) is record
            }
            for name, record in gone.items():
                del self._pending[name]
                reason = self._spool.quarantine_reason(name, record.since)
                if reason and is_point(name):
                    self._lost[key_of(name)] = reason
            if gone:
                self._last_progress = monotonic()
                self._deaths = 0
                self._changed.notify_all()
        for record in gone.values():
            record.on_delivery()

    def _raise_unusable(self) -> None:
        if self._unusable:
            raise ConfigError(self._unusable)


@cache
def background_delivery(folder: Path) -> BackgroundDelivery:
    """Return this process's only delivery of the spool in a folder."""
    return BackgroundDelivery(Spool(folder))


def _nothing() -> None:
    pass
