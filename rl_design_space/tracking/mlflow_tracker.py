"""Design points and sweeps on their way into MLflow: kept on disk at once, written by a process of its own."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

from rl_design_space.errors import ConfigError
from rl_design_space.tracking import record, summary
from rl_design_space.tracking.courier import Courier, courier_of
from rl_design_space.tracking.locks import claims_at, claims_path
from rl_design_space.tracking.origin import origin_tags
from rl_design_space.tracking.queries import source_of
from rl_design_space.tracking.spool import CLOSE, OPEN, STUDIES, TIDY, DamagedRecordError, Record, Spool, point_name
from rl_design_space.tracking.store_errors import StoreUnavailableError
from rl_design_space.tracking.tracker import DeliveryStatus, StoredRun, SweepEnding, SweepRecord
from rl_design_space.tracking.views import points_tags, sweeps_tags

if TYPE_CHECKING:
    from rl_design_space.learning.result import Kept, LearningCurves
    from rl_design_space.plan.plan import Plan, PlannedPoint
    from rl_design_space.tracking.address import StoreAddress

#: Seconds between two attempts to write a result to a full disk.
_PAUSE = 1.0


class MlflowTracker:
    """Keeps each point's result in a spool, from which it becomes one flat run; FINISHED is its commit mark.

    Args:
        address: of the store.
        spools: folder that keeps results until the store has them.
        command: that is recorded as the source of the runs.
        location: the store and the experiment in it, for messages.
        patience: seconds to wait for a store, or a disk, that takes nothing.
        curves: learning curves recorded beside those that always are.
        every: trials from one recorded value of a curve to the next.
        keep: what the artifact of a run holds.
        courier: delivers the spool; by default by a process of its own.

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
        courier: Courier | None = None,
    ) -> None:
        self.location = location
        self._patience = patience
        self._recorded: dict[str, Any] = {"curves": curves, "every": every, "keep": keep}
        self._source = source_of(address)
        self._spool = Spool.of(spools, address)
        self._courier = courier or courier_of(self._spool.folder)
        self._claims = claims_at(claims_path(address.uri))
        self._origin = origin_tags(command)
        #: Points whose records are on their way: claims that end when the store has them.
        self._on_their_way: set[str] = set()
        #: Whether the store could be asked what it has; if not, who delivers has to look for each point.
        self._known = True
        #: Whether the disk has been full for as long as to be waited for.
        self._full = False

    @property
    def unavailable(self) -> bool:
        """Whether the store could not be asked what it has."""
        return not self._known

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """The recorded points among these, by fingerprint; those that are on their way have no run yet.

        A store that cannot be reached is taken to have nothing: who delivers will find out.

        Raises:
            ConfigError: the store is of no use.
        """
        self._claims.forget()
        # In this order: what the store takes over in between is found in one of the two.
        kept = self._kept(fingerprints)
        return kept | self._stored(fingerprints)

    def lock(self, fingerprint: str) -> bool:
        """Lock a point for this process; return False while another process holds its lock."""
        return self._claims.take(fingerprint)

    def recorded_since(self, fingerprint: str) -> StoredRun | None:
        """Return the record of a point that was written after the last call of `finished`, if any."""
        if kept := self._kept([fingerprint]).get(fingerprint):
            return kept
        if not self._claims.announced(fingerprint):
            return None
        return self._stored([fingerprint]).get(fingerprint)

    def unlock(self, fingerprint: str) -> None:
        """Release the lock of a point; a pending record keeps it locked until it is delivered."""
        if fingerprint not in self._on_their_way:
            self._claims.release(fingerprint)

    def record(self, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
        """Write the result of a locked point to disk; it is durable on return.

        Raises:
            ConfigError: MLflow would not take a name, the store is of no use, or the disk is full and stays so.
        """
        kept = record.point_record(planned, curves, self._origin, checked=self._known, **self._recorded)
        self._keep(kept, planned.fingerprint)
        return StoredRun("", frozenset(planned.studies), kept.content["scalars"])

    def add_studies(self, stored: Mapping[str, StoredRun], studies: Mapping[str, Sequence[str]]) -> None:
        """Note that recorded points belong to these studies as well; both by fingerprint."""
        new = {
            fingerprint: record.study_tags(sorted(set(studies.get(fingerprint, ())) - run.studies))
            for fingerprint, run in stored.items()
        }
        if new := {fingerprint: tags for fingerprint, tags in new.items() if tags}:
            self._keep(Record(STUDIES, uuid4().hex, {"tags": new}))

    def open_sweep(self, plan: Plan, command: str) -> SweepRecord:
        """Start the summary run of a sweep that a command runs."""
        return _Sweep(self, plan, command)

    def wait_for_delivery(
        self, on_progress: Callable[[int, str], None] = lambda pending, problem: None
    ) -> DeliveryStatus:
        """Wait until every pending record is delivered, or the store has accepted none for `patience` seconds.

        Raises:
            ConfigError: the store is of no use.
        """
        self._have_tidied()
        left = self._courier.settle(self._patience, on_progress)
        points = {fingerprint: point_name(fingerprint) for fingerprint in self._on_their_way}
        lost = {fingerprint: left.aside[name] for fingerprint, name in points.items() if name in left.aside}
        return DeliveryStatus(left.awaiting, left.why, lost)

    def _have_tidied(self) -> None:
        """Have runs closed that dead processes have left; nobody claims what they were at."""
        for key in self._begun():
            going_on = self._spool.has(point_name(key)) or self._spool.has(Record(CLOSE, key, {}).name)
            if not going_on and self._claims.take(key):
                self._claims.release(key)
                self._keep(Record(TIDY, uuid4().hex, {}))
                return

    def _begun(self) -> list[str]:
        try:
            return self._source.begun(self._spool.identity)
        except StoreUnavailableError:
            return []

    def _kept(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """Points whose records are in the spool. One that is damaged is set aside; its point runs again."""
        found = {}
        for fingerprint in fingerprints:
            name = point_name(fingerprint)
            if not self._spool.has(name):
                continue
            try:
                content = self._spool.read(name).content
            except FileNotFoundError:
                continue
            except DamagedRecordError as error:
                self._spool.set_aside(name, f"damaged: {error}")
                continue
            studies = (
                tag.removeprefix(record.STUDY_TAG) for tag in content["tags"] if tag.startswith(record.STUDY_TAG)
            )
            found[fingerprint] = StoredRun("", frozenset(studies), content["scalars"])
        return found

    def _stored(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        try:
            return self._source.finished(fingerprints)
        except StoreUnavailableError:
            self._known = False
            return {}

    def _keep(self, kept: Record, fingerprint: str = "") -> None:
        """Write a record; wait for room on a full disk, which delivery may make."""
        until = time.monotonic() + self._patience
        while True:
            try:
                self._spool.write(kept)
                break
            except OSError as error:
                if self._full or time.monotonic() > until:
                    self._full = True
                    raise ConfigError(
                        f"{self._spool.folder}: {error.strerror}; make room and run the same command again, "
                        "or write elsewhere with outputs=DIR"
                    ) from error
                time.sleep(_PAUSE)
        if fingerprint:
            self._on_their_way.add(fingerprint)
        self._courier.watch(kept.name, lambda: self._delivered(fingerprint))

    def _delivered(self, fingerprint: str) -> None:
        if fingerprint:
            self._claims.release(fingerprint)


class _Sweep:
    """A summary run; it is claimed for as long as its sweep lives."""

    def __init__(self, tracker: MlflowTracker, plan: Plan, command: str) -> None:
        self._tracker = tracker
        self._plan = plan
        self._command = command
        self._key = uuid4().hex
        tracker._claims.take(self._key)
        note = summary.opening_note(plan, command, tracker._origin)
        self._content: dict[str, Any] = {
            "name": plan.name,
            "started": int(time.time() * 1000),
            "tags": {**record.study_tags(plan.studies), **tracker._origin, "mlflow.note.content": note},
        }
        started = self._content["started"]
        views = {"views": points_tags(plan, started), "sweep_views": sweeps_tags(started)}
        tracker._keep(Record(OPEN, self._key, {**self._content, **views}, summary.opening_tables(plan)))

    def close(self, ending: SweepEnding) -> None:
        content = {
            **self._content,
            "ended": int(time.time() * 1000),
            "status": ending.status,
            "note": summary.closing_note(self._plan, self._command, self._tracker._origin, ending),
            "metrics": [(f"points/{name}", float(count), 0) for name, count in ending.counts.items()],
        }
        self._tracker._keep(Record(CLOSE, self._key, content, summary.closing_tables(self._plan, ending)))
        self._tracker._claims.release(self._key)
