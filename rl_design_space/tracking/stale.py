"""Which RUNNING runs no process will finish."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from rl_design_space.tracking.address import sqlite_path
from rl_design_space.tracking.locks import PointLocks
from rl_design_space.tracking.spool import CLOSE, Record, Spool, point_name
from rl_design_space.tracking.tags import FINGERPRINT_TAG, SPOOL_TAG, SWEEP_TAG

#: Why such a run is incomplete.
DEAD = "the process that wrote it has ended"


@dataclass(frozen=True)
class RunningRun:
    """A RUNNING run of a point or a sweep.

    Attributes:
        spool: identity of the spool that it is written from.
        fingerprint: of the point; empty for a sweep.
        sweep: id of the sweep; empty for a point.
    """

    spool: str
    fingerprint: str
    sweep: str

    @classmethod
    def of(cls, tags: Mapping[str, str]) -> RunningRun:
        """Return the run that has these tags."""
        return cls(tags.get(SPOOL_TAG, ""), tags.get(FINGERPRINT_TAG, ""), tags.get(SWEEP_TAG, ""))

    def is_stale(self, spool: Spool, locks: PointLocks) -> bool:
        """Return whether no process will finish this run; False if that cannot be known here.

        The run of a point is finished by delivery of its record. A sweep is alive while its lock is held; all processes
        that use a SQLite file share its locks, those that use a server share them on one machine only.

        Args:
            spool: whose delivery lock is held, or that no process delivers.
            locks: of the points of the store.
        """
        is_ours = self.spool in spool.identities
        if self.sweep:
            is_here = is_ours or sqlite_path(spool.address.uri) is not None
            return is_here and not spool.has(Record(CLOSE, self.sweep, {}).name) and locks.is_free(self.sweep)
        return is_ours and not spool.has(point_name(self.fingerprint))
