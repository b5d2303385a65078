"""Delivers what is in a spool: tries again what may pass, sets aside what does not."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Callable
from contextlib import suppress
from threading import Event

from filelock import Timeout

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.connection import connect
from rl_design_space.tracking.deliver import Delivery
from rl_design_space.tracking.locks import claims_at, claims_path
from rl_design_space.tracking.queries import source_of
from rl_design_space.tracking.spool import DamagedRecordError, Spool, is_summary, key_of
from rl_design_space.tracking.store_errors import StoreUnavailableError, denial, passes, reason

#: Seconds between two looks into an empty spool, and between two attempts at a store that cannot be used: at first,
#: and at most.
_GLANCE, _FIRST_PAUSE, _LONGEST_PAUSE = 0.05, 0.5, 8.0
#: Times that a store may refuse a record; the second time it is looked at anew.
_REFUSALS = 2


class Writer:
    """Delivers records until it is told to end.

    Args:
        spool: where they are.
        tell: is told what is wrong with the store, or None when it can be used, or can be again.
        ended: whether to end; what is being delivered is ended first.
    """

    def __init__(self, spool: Spool, tell: Callable[[str | None], None], ended: Event) -> None:
        self._spool = spool
        self._tell = tell
        self._ended = ended
        self._failures: Counter[str] = Counter()
        self._pause = 0.0
        self._delivery: Delivery | None = None
        self._queue: deque[str] = deque()
        #: Records that the store may have part of, or all.
        self._begun: set[str] = set()

    def run_until(self, stopped: Callable[[], bool]) -> None:
        """Deliver records as they come, until told to stop or to end.

        Raises:
            ConfigError: the store is of no use.
        """
        while not (stopped() or self._ended.is_set()):
            if not self._deliver_next():
                self._ended.wait(_GLANCE)
            elif self._pause:
                self._ended.wait(self._pause)

    def leave(self) -> None:
        """Tell how the sweep went before ending, whatever else waits.

        Raises:
            ConfigError: the store is of no use.
        """
        if self._delivery and not self._pause:
            for name in self._spool.waiting():
                if is_summary(name):
                    self._deliver(name, self._delivery)

    def run_until_empty(self, patience: float) -> None:
        """Deliver all records, or give up when none could be delivered for so many seconds.

        Raises:
            ConfigError: the store is of no use.
        """
        until = time.monotonic() + patience
        while self._deliver_next():
            if not self._pause:
                until = time.monotonic() + patience
            elif time.monotonic() + self._pause > until:
                return
            self._ended.wait(self._pause)

    def _deliver_next(self) -> bool:
        """Deliver the next record; False if there is none."""
        try:
            delivery = self._opened()
        except StoreUnavailableError as error:
            self._trouble(str(error))
            return True
        if not self._queue:
            # What has failed comes last: it may be at fault itself.
            self._queue.extend(sorted(self._spool.waiting(), key=lambda name: self._failures[name]))
        if not self._queue:
            return False
        self._deliver(self._queue.popleft(), delivery)
        return True

    def _deliver(self, name: str, delivery: Delivery) -> None:
        try:
            record = self._spool.read(name)
        except FileNotFoundError:
            return
        except DamagedRecordError as error:
            self._set_aside(name, f"damaged: {error}", delivery)
            return
        again = name in self._begun or bool(self._failures[name]) or not record.content.get("checked", True)
        try:
            delivery(record, again)
        except ConfigError:
            raise
        except Exception as error:
            if denied := denial(self._spool.address.uri, error):
                raise denied from error
            self._failures[name] += 1
            if passes(error) or self._failures[name] < _REFUSALS:
                self._trouble(reason(error))
            else:
                self._set_aside(name, f"refused: {reason(error)}", delivery)
        else:
            self._spool.remove(name)
            self._begun.discard(name)
            self._fine()

    def _set_aside(self, name: str, why: str, delivery: Delivery) -> None:
        self._spool.set_aside(name, why)
        with suppress(Exception):  # what is left of its run is closed now, or when a writer starts again
            delivery.close_stale_runs()

    def _opened(self) -> Delivery:
        if self._delivery is None:
            address = self._spool.address
            client = connect(address.uri)
            delivery = Delivery(client, self._spool, claims_at(claims_path(address.uri)))
            try:
                delivery.close_stale_runs()
            except Exception as error:
                if denied := denial(address.uri, error):
                    raise denied from error
                if not passes(error):
                    raise
                raise StoreUnavailableError(reason(error)) from error
            self._begun = self._begun_before()
            self._spool.sweep_up()
            self._delivery = delivery
            self._tell(None)
            self._fine()
        return self._delivery

    def _begun_before(self) -> set[str]:
        """Records that were here before, and of which the store has a run."""
        names = {key_of(name): name for name in self._spool.waiting()}
        source = source_of(self._spool.address)
        known = {*source.finished(list(names)), *source.begun(self._spool.identity)}
        return {name for key, name in names.items() if key in known}

    def _trouble(self, what: str) -> None:
        self._pause = min(2 * self._pause, _LONGEST_PAUSE) if self._pause else _FIRST_PAUSE
        self._tell(what)

    def _fine(self) -> None:
        if self._pause:
            self._tell(None)
        self._pause = 0.0


def deliver_all(spool: Spool, patience: float) -> str:
    """Deliver a spool in this process.

    Args:
        spool: what to deliver.
        patience: seconds without any delivery after which to give up.

    Returns:
        What kept it from being delivered wholly, if anything.

    Raises:
        ConfigError: the store is of no use.
    """
    trouble = ""

    def tell(what: str | None) -> None:
        nonlocal trouble
        trouble = what or ""

    try:
        with spool.lock.acquire(timeout=patience):
            Writer(spool, tell, Event()).run_until_empty(patience)
    except Timeout:
        return "another process is at it"
    return trouble
