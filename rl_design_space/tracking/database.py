"""The tables of an MLflow database, read without MLflow, which takes 20 seconds for 10,000 runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any

from rl_design_space.tracking.address import StoreAddress, sqlite_path
from rl_design_space.tracking.store_errors import deleted_experiment, translated

if TYPE_CHECKING:
    from sqlalchemy import Connection, Engine

_TABLES = {"experiments", "runs", "tags", "params", "latest_metrics"}
_RUNS = """
    from runs r join experiments e on e.experiment_id = r.experiment_id
    where e.name = :experiment and r.status = 'FINISHED' and r.lifecycle_stage = 'active'
"""


class Database:
    """An MLflow database, for reading.

    Args:
        address: of the store; a SQLite file that does not exist holds nothing.
    """

    def __init__(self, address: StoreAddress) -> None:
        self._address = address
        self._connections: Engine | None = None

    @contextmanager
    def reading(self) -> Iterator[Rows]:
        """The complete runs of the experiment, all as they are at one moment.

        Raises:
            ConfigError: the store is of no use.
            StoreUnavailableError: it cannot be reached at the moment.
        """
        path = sqlite_path(self._address.uri)
        if path and not path.exists():
            yield Rows(None, self._address)
            return
        import sqlalchemy

        with ExitStack() as stack:
            with _translated(self._address.uri):
                self._connections = self._connections or sqlalchemy.create_engine(self._address.uri)
                connection = stack.enter_context(self._connections.connect())
                # Another process may be creating them right now.
                there = set(sqlalchemy.inspect(connection).get_table_names()) >= _TABLES
            rows = Rows(connection if there else None, self._address)
            rows.check_experiment()
            yield rows


class Rows:
    """What is in the tables; nothing where there are none.

    Runs are given by their ids; None asks for all complete runs.
    """

    def __init__(self, connection: Connection | None, address: StoreAddress) -> None:
        self._connection = connection
        self._address = address

    def check_experiment(self) -> None:
        """Refuse an experiment that somebody has deleted.

        Raises:
            ConfigError: it was.
        """
        stages = self._ask("select lifecycle_stage from experiments e where e.name = :experiment")
        if ("deleted",) in stages:
            raise deleted_experiment("experiment", self._address.experiment)

    def experiment_id(self) -> str | None:
        """Of the experiment, if there is one."""
        found = self._ask("select e.experiment_id from experiments e where e.name = :experiment")
        return str(found[0][0]) if found else None

    def finished(self, fingerprints: Sequence[str] | None) -> Iterable[tuple[str, str, str]]:
        """Complete runs of points as (run, fingerprint, place of its artifacts); of all points if None."""
        if fingerprints is not None and not fingerprints:
            return []
        query = f"select r.run_uuid, t.value, r.artifact_uri {_joined('tags t')} and t.key = 'fingerprint'"
        if fingerprints is None:
            return self._ask(query)
        return self._ask(f"{query} and t.value in :among", among=fingerprints)

    def metrics(self, runs: Sequence[str] | None, names: Sequence[str] = ()) -> Iterable[tuple[str, str, float]]:
        """Last values of metrics, as (run, name, value); of all metrics if none are named."""
        return self._values("latest_metrics", runs, "and v.key in :names" if names else "", names=names)

    def params(self, runs: Sequence[str] | None) -> Iterable[tuple[str, str, str]]:
        """Params, as (run, name, value)."""
        return self._values("params", runs, "")

    def tags(self, runs: Sequence[str] | None, prefix: str = "") -> Iterable[tuple[str, str, str]]:
        """Tags whose names begin with something, as (run, name, value)."""
        return self._values("tags", runs, "and substr(v.key, 1, :length) = :prefix", prefix=prefix, length=len(prefix))

    def about(self, runs: Sequence[str] | None) -> Iterable[tuple[str, str, int, int, str]]:
        """Run, its name, when it began and ended (milliseconds since 1970), and where its artifacts are."""
        among = "and r.run_uuid in :among" if runs is not None else ""
        return self._ask(
            f"select r.run_uuid, r.name, r.start_time, r.end_time, r.artifact_uri {_RUNS} {among}", among=runs
        )

    def begun(self, spool: str) -> list[str]:
        """Fingerprints and ids of sweeps, of RUNNING runs that a spool has begun, in any experiment."""
        query = """
            select key.value from runs r join tags t on t.run_uuid = r.run_uuid
            join tags key on key.run_uuid = r.run_uuid and key.key in ('fingerprint', 'rl_design_space.sweep')
            where r.status = 'RUNNING' and r.lifecycle_stage = 'active'
            and t.key = 'rl_design_space.spool' and t.value = :spool
        """
        return [key for (key,) in self._ask(query, spool=spool)]

    def count(self) -> dict[tuple[str, str], int]:
        """Numbers of all runs, by stage of life (active, deleted) and status."""
        query = """
            select r.lifecycle_stage, r.status, count(*)
            from runs r join experiments e on e.experiment_id = r.experiment_id
            where e.name = :experiment group by r.lifecycle_stage, r.status
        """
        return {(stage, status): count for stage, status, count in self._ask(query)}

    def _values(self, table: str, runs: Sequence[str] | None, more: str, **values: Any) -> list[Any]:
        if runs is not None and not runs:
            return []
        among = "and r.run_uuid in :among" if runs is not None else ""
        query = f"select v.run_uuid, v.key, v.value {_joined(f'{table} v')} {among} {more}"
        return self._ask(query, among=runs, **values)

    def _ask(self, query: str, **values: Any) -> list[Any]:
        import sqlalchemy

        if self._connection is None:
            return []
        values["experiment"] = self._address.experiment
        names = [name for name in values if f":{name}" in query]
        several = [name for name in names if name in ("among", "names")]
        statement = sqlalchemy.text(query).bindparams(*(sqlalchemy.bindparam(name, expanding=True) for name in several))
        with _translated(self._address.uri):
            return list(self._connection.execute(statement, {name: values[name] for name in names}))


@contextmanager
def _translated(uri: str) -> Iterator[None]:
    """Errors of SQLAlchemy, or of a driver, as ours."""
    try:
        yield
    except Exception as error:
        raise translated(uri, error) from error


def _joined(table: str) -> str:
    """The complete runs, joined with a table that has rows for each."""
    return _RUNS.replace("where", f"join {table} on {table[-1]}.run_uuid = r.run_uuid where")
