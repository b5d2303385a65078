"""Queries of a tracking store: which points it has, and what their runs hold."""

from __future__ import annotations

from collections.abc import Collection
from typing import Protocol

from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.database import DatabaseQueries
from rl_design_space.tracking.found_run import FoundRun, RunCounts
from rl_design_space.tracking.server import ServerQueries
from rl_design_space.tracking.stale import RunningRun
from rl_design_space.tracking.tracker import StoredRun


class Queries(Protocol):
    """Queries of the experiment that holds the design points.

    Each method raises ConfigError if the store cannot be used, and StoreUnavailableError if it cannot be reached at the
    moment.
    """

    @property
    def experiment(self) -> str:
        """Id of the experiment.

        Raises:
            ConfigError: there is no experiment of that name.
        """
        ...

    def runs(self) -> list[FoundRun]:
        """Return all complete runs."""
        ...

    def counts(self) -> RunCounts:
        """Count the runs by status."""
        ...

    def check(self, *, sweeps: bool) -> str:
        """Check that results can be recorded: no experiment was deleted.

        Args:
            sweeps: whether the experiment of the sweeps is needed.

        Returns:
            What users should know about recording into this store; usually empty.
        """
        ...

    def recorded(self, fingerprints: Collection[str]) -> set[str]:
        """Return those of these points that have a complete run."""
        ...

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """Return the complete runs among these points, by fingerprint."""
        ...

    def period_counts(self) -> set[int]:
        """Return the numbers of periods that complete runs have."""
        ...

    def newest_sweep(self, study: str) -> StoredRun | None:
        """Return the summary run of the last sweep of a study, if there is one."""
        ...

    def running(self) -> list[RunningRun]:
        """Return the RUNNING runs of points and sweeps."""
        ...


def queries_of(address: StoreAddress) -> Queries:
    """Return the queries of a store; a database is read without MLflow, which takes 20 seconds for 10,000 runs."""
    return ServerQueries(address) if address.is_server else DatabaseQueries(address)
