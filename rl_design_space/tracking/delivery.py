"""Delivery of the pending records of a spool: transient errors are retried, refused records are quarantined."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from threading import Event

from filelock import Timeout

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.locks import locks_at, locks_path
from rl_design_space.tracking.record_schema import checked
from rl_design_space.tracking.spool import REFUSED, CorruptedRecordError, Record, Spool, is_summary
from rl_design_space.tracking.store_errors import (
    DeletedExperimentError,
    StoreUnavailableError,
    access_error,
    first_line,
    is_transient,
)
from rl_design_space.tracking.store_writer import StoreWriter, open_writer

#: Seconds between two looks into an empty spool, and the longest pause between two attempts.
_POLL, _LONGEST_PAUSE = 0.05, 8.0
#: Number of times that the store has to refuse a record before it is quarantined.
_REFUSALS = 2


class Delivery:
    """Delivers the records of a spool, whose lock the caller holds.

    Args:
        spool: where the records are.
        on_problem: called with what is wrong with the store, and with None when it is open and nothing is wrong.
        ended: ends delivery after the current record.
        first_pause: seconds from a transient error to the next attempt; doubled after each further error.
    """

    def __init__(
        self, spool: Spool, on_problem: Callable[[str | None], None], ended: Event, *, first_pause: float = 0.5
    ) -> None:
        self._spool = spool
        self._on_problem = on_problem
        self._ended = ended
        self._first_pause = first_pause
        #: Seconds until the next attempt; 0 while nothing is wrong.
        self._pause = 0.0
        self._writer: StoreWriter | None = None
        self._queue: deque[str] = deque()
        #: Numbers of failures of each record; how often the store has refused it.
        self._failures: Counter[str] = Counter()
        self._refusals: Counter[str] = Counter()
        #: Records for an experiment that was deleted.
        self._blocked: dict[str, DeletedExperimentError] = {}

    def run_while(self, active: Callable[[], bool]) -> None:
        """Deliver records as they are written, until a condition no longer holds or `ended` is set.

        Raises:
            ConfigError: the store cannot be used.
        """
        while active() and not self._ended.is_set():
            if not self._deliver_next():
                self._ended.wait(_POLL)
            elif self._pause:
                self._ended.wait(self._pause)

    def run_until_empty(self, patience: float) -> None:
        """Deliver all records; give up when none could be delivered for so many seconds.

        Raises:
            ConfigError: the store cannot be used.
        """
        until = time.monotonic() + patience
        while self._deliver_next():
            if not self._pause:
                until = time.monotonic() + patience
            elif time.monotonic() + self._pause > until:
                return
            self._ended.wait(self._pause)

    def deliver_summaries(self) -> None:
        """Deliver the pending beginnings and ends of sweeps, if the store is open and nothing is wrong.

        Raises:
            ConfigError: the store cannot be used.
        """
        if self._writer and not self._pause:
            self._deliver([name for name in self._spool.pending() if is_summary(name)], self._writer)

    def close(self) -> None:
        """Close the connection to the store, which is opened again when there is something to deliver."""
        if self._writer:
            self._writer.close()
            self._writer = None

    def _deliver_next(self) -> bool:
        """Deliver the next records; return False if there are none."""
        try:
            writer = self._opened()
        except StoreUnavailableError as error:
            self._failed(str(error))
            return True
        if not self._queue:
            # Records that have failed come last: they may be the cause.
            pending = [name for name in self._spool.pending() if name not in self._blocked]
            self._queue.extend(sorted(pending, key=lambda name: self._failures[name]))
        if not self._queue:
            self._raise_if_blocked()
            return False
        self._deliver(self._next_names(writer.batch), writer)
        return True

    def _next_names(self, batch: int) -> list[str]:
        """Take the next records from the queue; one that has failed alone, because it may be the cause."""
        names = [self._queue.popleft()]
        if not self._failures[names[0]]:
            while self._queue and len(names) < batch and not self._failures[self._queue[0]]:
                names.append(self._queue.popleft())
        return names

    def _deliver(self, names: Sequence[str], writer: StoreWriter) -> None:
        records = [record for name in names if (record := self._read(name, writer))]
        if not records:
            return
        try:
            writer.write(records)
        except DeletedExperimentError as error:
            self._postpone(records, error)
        except ConfigError:
            raise
        except CorruptedRecordError as error:
            self._quarantine(error.name, str(error), writer)
            self._queue.extendleft(record.name for record in reversed(records) if record.name != error.name)
        except Exception as error:
            if denied := access_error(self._spool.address.uri, error):
                raise denied from error
            self._failures.update(record.name for record in records)
            if is_transient(error):
                if isinstance(error, StoreUnavailableError):
                    self.close()
                self._failed(first_line(error))
            elif len(records) > 1:
                self._queue.extendleft(record.name for record in reversed(records))
            else:
                self._refused(records[0].name, first_line(error), writer)
        else:
            for record in records:
                self._spool.remove(record.name)
            self._succeeded()

    def _postpone(self, records: Sequence[Record], error: DeletedExperimentError) -> None:
        """Deliver first what does not need the experiment that was deleted."""
        self._failures.update(record.name for record in records)
        if len(records) > 1:
            self._queue.extendleft(record.name for record in reversed(records))
        else:
            self._blocked[records[0].name] = error

    def _raise_if_blocked(self) -> None:
        for name, error in self._blocked.items():
            if self._spool.has(name):
                raise error

    def _read(self, name: str, writer: StoreWriter) -> Record | None:
        """Return a pending record; None if it has been delivered, or cannot be and is quarantined."""
        try:
            return checked(self._spool.read(name))
        except FileNotFoundError:
            return None
        except CorruptedRecordError as error:
            self._quarantine(name, str(error), writer)
            return None

    def _refused(self, name: str, reason: str, writer: StoreWriter) -> None:
        self._refusals[name] += 1
        if self._refusals[name] < _REFUSALS:
            self._failed(reason)
        else:
            self._quarantine(name, f"{REFUSED}: {reason}", writer)

    def _quarantine(self, name: str, reason: str, writer: StoreWriter) -> None:
        self._spool.quarantine(name, reason)
        with suppress(Exception):  # its run is closed now, or when delivery starts again
            writer.close_stale_runs()

    def _opened(self) -> StoreWriter:
        """Open the store before the first record."""
        if self._writer is None:
            address = self._spool.address
            try:
                writer = open_writer(self._spool, locks_at(locks_path(address.uri)))
                writer.close_stale_runs()
            except (ConfigError, StoreUnavailableError):
                raise
            except Exception as error:
                if denied := access_error(address.uri, error):
                    raise denied from error
                if not is_transient(error):
                    raise
                raise StoreUnavailableError(first_line(error)) from error
            self._spool.remove_abandoned()
            self._writer = writer
            self._on_problem(None)
            self._pause = 0.0
        return self._writer

    def _failed(self, problem: str) -> None:
        self._pause = min(2 * self._pause, _LONGEST_PAUSE) if self._pause else self._first_pause
        self._on_problem(problem)

    def _succeeded(self) -> None:
        if self._pause:
            self._on_problem(None)
        self._pause = 0.0


def deliver_all(spool: Spool, patience: float) -> str:
    """Deliver all records of a spool in this process.

    Args:
        spool: where the records are.
        patience: seconds without any delivery after which to give up.

    Returns:
        Why records are still pending; empty if none are.

    Raises:
        ConfigError: the store cannot be used.
    """
    current = ""

    def note(problem: str | None) -> None:
        nonlocal current
        current = problem or ""

    try:
        with spool.lock.acquire(timeout=patience), closing(Delivery(spool, note, Event())) as delivery:
            delivery.run_until_empty(patience)
    except Timeout:
        return "another process is delivering them"
    return current
