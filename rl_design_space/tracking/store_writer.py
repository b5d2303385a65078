"""Writing records into a tracking store, each exactly once, however often it is attempted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from rl_design_space.tracking.connection import connect
from rl_design_space.tracking.locks import PointLocks
from rl_design_space.tracking.spool import Record, Spool


class StoreWriter(Protocol):
    """Writes the records of a spool, whose lock the caller holds.

    Attributes:
        batch: maximum number of records that are written at a time.
    """

    batch: int

    def write(self, records: Sequence[Record]) -> None:
        """Write records in this order; several are written all or none.

        Raises:
            ConfigError: the store cannot be used.
            Exception: whatever MLflow, the database or the file system raises; writing may be attempted again.
        """
        ...

    def close_stale_runs(self) -> None:
        """Mark as KILLED the RUNNING runs that no process will finish.

        Raises:
            Exception: see `write`.
        """
        ...

    def close(self) -> None:
        """Close connections."""
        ...


def open_writer(spool: Spool, locks: PointLocks) -> StoreWriter:
    """Open the store of a spool, which is created or migrated if need be.

    Databases are written to directly if their schema is one that this is tested with; everything else through MLflow's
    client.

    Args:
        spool: whose records will be written.
        locks: of the points of the store.

    Raises:
        ConfigError: the store cannot be used.
        StoreUnavailableError: the store cannot be reached or written to at the moment.
    """
    address = spool.address
    if not address.is_server:
        from rl_design_space.tracking.database_engine import open_known_database
        from rl_design_space.tracking.database_writer import DatabaseWriter

    if not address.is_server and (engine := open_known_database(address.uri)):
        writer = DatabaseWriter(engine, spool, locks)
        if writer.has_local_artifacts():
            return writer
        writer.close()
    from rl_design_space.tracking.client_writer import ClientWriter

    return ClientWriter(connect(address.uri), spool, locks)
