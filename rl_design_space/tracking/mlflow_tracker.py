"""A tracker that records into MLflow: results go to the spool at once, a process of its own delivers them."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar
from uuid import uuid4

from rl_design_space.errors import ConfigError
from rl_design_space.tracking import record, summary
from rl_design_space.tracking.background import BackgroundDelivery, background_delivery
from rl_design_space.tracking.beginnings import beginnings
from rl_design_space.tracking.leaderboard import Leaderboard
from rl_design_space.tracking.locks import locks_at, locks_path
from rl_design_space.tracking.origin import origin_tags
from rl_design_space.tracking.queries import queries_of
from rl_design_space.tracking.record_schema import checked
from rl_design_space.tracking.spool import CLOSE, OPEN, STUDIES, TIDY, CorruptedRecordError, Record, Spool, point_name
from rl_design_space.tracking.stale import RunningRun
from rl_design_space.tracking.store_errors import StoreUnavailableError
from rl_design_space.tracking.tags import NOTE_TAG, study_tags
from rl_design_space.tracking.tracker import Beginning, DeliveryStatus, StoredRun, SweepEnding, SweepRecord
from rl_design_space.tracking.views import points_tags, sweeps_tags

if TYPE_CHECKING:
    from rl_design_space.learning.result import Kept, LearningCurves
    from rl_design_space.plan.plan import Plan, PlannedPoint
    from rl_design_space.tracking.address import StoreAddress

Answer = TypeVar("Answer")


class MlflowTracker:
    """Writes the result of each point to a spool, from which it becomes one flat run whose commit mark is FINISHED.

    Args:
        address: of the store.
        spools: folder of all spools.
        command: recorded as the source of the runs.
        location: the store and the experiment in it, for messages.
        patience: seconds to wait for a store, or a disk, that accepts nothing.
        curves: names of the curves to record in addition to `measures.CURVES`.
        every: number of trials from one recorded value of a curve to the next.
        keep: what the artifact of a run holds.
        leaderboard: names of the measures that the points of a sweep are ranked by, the first above all.
        delivery: delivers the spool; a tracker process by default.
        retry_pause: seconds between two attempts to write a record to a full disk.

    Raises:
        ConfigError: the spool cannot be used.
    """

    def __init__(
        self,
        address: StoreAddress,
        spools: Path,
        command: str,
        *,
        location: str,
        patience: float,
        curves: Sequence[str] = (),
        every: int = 1,
        keep: Kept = "periods",
        leaderboard: Sequence[str] = ("total_steps",),
        delivery: BackgroundDelivery | None = None,
        retry_pause: float = 1.0,
    ) -> None:
        self.location = location
        self._patience = patience
        self._spools = spools
        self._retry_pause = retry_pause
        self._recorded: dict[str, Any] = {"curves": curves, "every": every, "keep": keep}
        self._queries = queries_of(address)
        self._leaderboard = Leaderboard(leaderboard, address)
        self._spool = Spool.of(spools, address)
        self._delivery = delivery or background_delivery(self._spool.folder)
        self._locks = locks_at(locks_path(address.uri))
        self._origin = origin_tags(command)
        #: Fingerprints of the points recorded by this tracker; delivery of their records releases their locks.
        self._written: set[str] = set()
        #: Numbers of periods of these points.
        self._counts: set[int] = set()
        #: Those of them that the store is known to have.
        self._found: set[str] = set()
        #: Whether the store has answered which points it has; if not, delivery looks for each point first.
        self._store_answers = True
        #: Until when it is not asked again, because asking takes seconds.
        self._silent_until = 0.0
        #: Whether the store is known to accept results, as far as that can be known before there are any.
        self._is_checked = False
        self._note = ""
        #: Whether the disk has been full for `patience` seconds.
        self._disk_is_full = False

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """Return the recorded points among these, by fingerprint; those with a pending record have no run id yet.

        A store that cannot be reached is taken to have none; delivery finds out.

        Raises:
            ConfigError: the store cannot be used.
        """
        self._check_store()
        self._locks.skip_journal()
        # In this order: a record that is delivered in between is found in one of the two.
        pending = self._pending(fingerprints)
        return pending | self._stored(fingerprints)

    def beginnings(self, points: Collection[PlannedPoint]) -> dict[str, Beginning]:
        """Return the longest recorded run of each of these points with another number of periods, by fingerprint."""
        counts = self._asked(self._queries.period_counts, set[int]()) | self._counts
        return beginnings(points, counts, lambda wanted: self._pending(wanted) | self._stored(wanted))

    def result(self, beginning: Beginning, planned: PlannedPoint) -> LearningCurves | None:
        """Return the result of such a run; None if it cannot be read, or is not what was recorded."""
        from rl_design_space.tracking.begun_result import begun_result  # which few sweeps need

        return begun_result(beginning, planned.point.task.trials, self._spool, self._stored)

    def lock(self, fingerprint: str) -> bool:
        """Lock a point for this process; return False while another process holds its lock."""
        return self._locks.acquire(fingerprint)

    def recorded_since(self, fingerprint: str) -> StoredRun | None:
        """Return the record of a point that was written after the last call of `finished`, if any."""
        if pending := self._pending([fingerprint]).get(fingerprint):
            return pending
        if not self._locks.in_journal(fingerprint):
            return None
        return self._stored([fingerprint]).get(fingerprint)

    def unlock(self, fingerprint: str) -> None:
        """Release the lock of a point; a pending record keeps it locked until it is delivered."""
        if fingerprint not in self._written:
            self._locks.release(fingerprint)

    def record(self, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
        """Write the result of a locked point to disk; it is durable on return.

        Raises:
            ConfigError: MLflow would refuse a name, the store cannot be used, or the disk stays full.
        """
        written = record.point_record(planned, curves, self._origin, checked=self._store_answers, **self._recorded)
        self._write(written)
        self._written.add(planned.fingerprint)
        self._counts.add(len(curves.steps))
        self._leaderboard.add(planned.fingerprint, curves)
        self._delivery.watch(written.name, lambda: self._locks.release(planned.fingerprint))
        return record.pending_run(written)

    def add_studies(self, stored: Mapping[str, StoredRun], studies: Mapping[str, Sequence[str]]) -> None:
        """Note that recorded points belong to these studies as well; both by fingerprint."""
        new = {
            fingerprint: study_tags(sorted(set(studies.get(fingerprint, ())) - run.studies))
            for fingerprint, run in stored.items()
        }
        if new := {fingerprint: tags for fingerprint, tags in new.items() if tags}:
            self._submit(Record(STUDIES, uuid4().hex, {"tags": new}))

    def open_sweep(self, plan: Plan, command: str) -> SweepRecord:
        """Start the summary run of a sweep that a command runs.

        Raises:
            ConfigError: the store cannot be used.
        """
        self._asked(lambda: self._queries.check(sweeps=True), "")
        return _Sweep(self, plan, command)

    def wait_for_delivery(
        self, on_progress: Callable[[int, str], None] = lambda pending, problem: None
    ) -> DeliveryStatus:
        """Wait until every pending record is delivered, or the store has accepted none for `patience` seconds.

        Raises:
            ConfigError: the store cannot be used.
        """
        self._close_stale_runs()
        status = self._delivery.wait(self._patience, on_progress)
        lost = {fingerprint: reason for fingerprint, reason in status.lost.items() if fingerprint in self._written}
        if not status.pending:
            self._silent_until = 0.0
            lost |= self._removed(lost)
        return DeliveryStatus(status.pending, status.reason, lost, self._note, str(self._spools))

    def _removed(self, lost: Mapping[str, str]) -> dict[str, str]:
        """Return the delivered points that a database does not have, with the reason."""
        if self._spool.address.is_server or not self._written - self._found:
            return {}
        self._found |= self._asked(lambda: self._queries.recorded(self._written), self._written)
        reason = "its run is not in the store any more: runs were removed, or the database was replaced"
        return dict.fromkeys(self._written - self._found - lost.keys(), reason)

    def _close_stale_runs(self) -> None:
        """Have the runs of dead processes closed, if there are any."""
        running: list[RunningRun] = []
        if any(run.is_stale(self._spool, self._locks) for run in self._asked(self._queries.running, running)):
            self._submit(Record(TIDY, uuid4().hex, {}))

    def _pending(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """Return the points with a pending record; a corrupted record is quarantined, so that its point runs again."""
        found = {}
        for fingerprint in fingerprints:
            name = point_name(fingerprint)
            if not self._spool.has(name):
                continue
            try:
                read = checked(self._spool.read(name))
            except FileNotFoundError:
                continue
            except CorruptedRecordError as error:
                self._spool.quarantine(name, str(error))
                continue
            found[fingerprint] = record.pending_run(read)
        return found

    def _check_store(self) -> None:
        if not self._is_checked:
            self._note = self._asked(lambda: self._queries.check(sweeps=False), "")
            self._is_checked = True

    def _stored(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        nothing: dict[str, StoredRun] = {}
        return self._asked(lambda: self._queries.finished(fingerprints), nothing)

    def _asked(self, query: Callable[[], Answer], otherwise: Answer) -> Answer:
        """Return the answer of the store; `otherwise` if it does not answer, or has not within its patience."""
        if time.monotonic() < self._silent_until:
            return otherwise
        try:
            return query()
        except StoreUnavailableError:
            self._store_answers = False
            self._silent_until = time.monotonic() + self._patience
            return otherwise

    def _submit(self, written: Record) -> None:
        """Write a record that is not that of a point, and deliver it."""
        self._write(written)
        self._delivery.watch(written.name, lambda: None)

    def _write(self, written: Record) -> None:
        """Write a record; wait for space on a full disk, which delivery may free."""
        until = time.monotonic() + self._patience
        while True:
            try:
                self._spool.write(written)
                return
            except OSError as error:
                if self._disk_is_full or time.monotonic() > until:
                    self._disk_is_full = True
                    raise ConfigError(
                        f"{self._spool.folder}: {error.strerror}; free some space and run the same command again, "
                        "or write elsewhere with outputs=DIR"
                    ) from error
                time.sleep(self._retry_pause)


class _Sweep:
    """The summary run of a sweep; it is locked while the sweep lives."""

    def __init__(self, tracker: MlflowTracker, plan: Plan, command: str) -> None:
        self._tracker = tracker
        self._plan = plan
        self._command = command
        self._key = uuid4().hex
        tracker._locks.acquire(self._key)
        self._ranking = tracker._leaderboard
        note = summary.opening_note(plan, command, tracker._origin)
        self._content: dict[str, Any] = {
            "name": plan.name,
            "started": int(time.time() * 1000),
            "tags": {**study_tags(plan.studies), **tracker._origin, NOTE_TAG: note},
        }
        started = self._content["started"]
        views = {"views": points_tags(plan, started), "sweep_views": sweeps_tags(started)}
        tracker._submit(Record(OPEN, self._key, {**self._content, **views}, summary.opening_tables(plan)))

    def close(self, ending: SweepEnding) -> None:
        """End the run."""
        if ending.status != "KILLED":  # a sweep that is stopped does not wait for the store
            # Records that were pending when their points were recorded may be delivered now.
            pending = [fingerprint for fingerprint, run in ending.stored.items() if not run.run_id]
            ending = replace(ending, stored={**ending.stored, **self._tracker._stored(pending)})
        names, is_stopped = self._ranking.names, ending.status == "KILLED"
        ending = replace(ending, stored=self._ranking.measured(ending.stored, may_read=not is_stopped))
        content = {
            **self._content,
            "ended": int(time.time() * 1000),
            "status": ending.status,
            "note": summary.closing_note(self._plan, self._command, self._tracker._origin, ending, names),
            "metrics": [
                *((f"points/{name}", float(count), 0) for name, count in ending.counts.items()),
                *((name, float(value), 0) for name, value in ending.findings.metrics.items()),
            ],
        }
        self._tracker._submit(Record(CLOSE, self._key, content, summary.closing_tables(self._plan, ending, names)))
        self._tracker._locks.release(self._key)
