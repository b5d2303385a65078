"""Queries of the tables of an MLflow database, without MLflow, which takes 20 seconds for 10,000 runs."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from rl_design_space.learning.measures import SCALARS
from rl_design_space.tracking.address import StoreAddress, sqlite_path
from rl_design_space.tracking.found_run import FoundRun, RunCounts
from rl_design_space.tracking.read_only import reading_engine
from rl_design_space.tracking.stale import RunningRun
from rl_design_space.tracking.store_errors import as_tracking_error, deleted_experiment, missing_experiment
from rl_design_space.tracking.tags import FINGERPRINT_TAG, PRECISION_TAG, STUDY_TAG, enough, studies_of
from rl_design_space.tracking.tracker import Enough, StoredRun

if TYPE_CHECKING:
    from sqlalchemy import Connection, Engine

Value = TypeVar("Value")

#: Up to so many points are searched for by their fingerprints; for more, all runs are read.
_FEW = 20
_PRECISION = f"{PRECISION_TAG}."
_TABLES = {"experiments", "runs", "tags", "params", "latest_metrics"}
_RUNS = """
    from runs r join experiments e on e.experiment_id = r.experiment_id
    where e.name = :experiment and r.status = 'FINISHED' and r.lifecycle_stage = 'active'
"""


class _Finished(NamedTuple):
    """A complete run of a point: id, URI of its files, fingerprint of the point, and what its precision needed."""

    run_id: str
    artifacts: str
    fingerprint: str
    enough: Enough | None


class DatabaseQueries:
    """Queries of an MLflow database, see `Queries`.

    Args:
        address: of the store; a SQLite file that does not exist is read as an empty database.
    """

    def __init__(self, address: StoreAddress) -> None:
        self._address = address
        self._connections: Engine | None = None

    @property
    def experiment(self) -> str:
        """Id of the experiment."""
        with self._reading() as rows:
            experiment = rows.experiment_id()
        if experiment is None:
            raise missing_experiment(self._address)
        return experiment

    def runs(self) -> list[FoundRun]:
        """Return all complete runs."""
        with self._reading() as rows:
            runs = rows.runs()
            params, metrics, tags = _by_run(rows.params()), _by_run(rows.metrics(None)), _by_run(rows.tags(None))
        return [FoundRun(*run, params[run[0]], metrics[run[0]], tags[run[0]]) for run in runs]

    def counts(self) -> RunCounts:
        """Count the runs by status."""
        with self._reading() as rows:
            return RunCounts.of(rows.counts())

    def check(self, *, sweeps: bool) -> str:
        """Check that results can be recorded; return a note if they are not written directly."""
        with self._reading() as rows:
            if sweeps:
                rows.check_experiment("sweeps", self._address.sweeps)
            revision = rows.revision()
        from rl_design_space.tracking.database_tables import REVISIONS

        if not revision or revision in REVISIONS:
            return ""
        return (
            f"{self._address.uri}: its schema {revision} is not one that this version is tested with, so results are "
            "recorded by MLflow's client, which takes longer; a later version of rl-design-space may know it"
        )

    def recorded(self, fingerprints: Collection[str]) -> set[str]:
        """Return those of these points that have a complete run."""
        few = list(fingerprints) if len(fingerprints) <= _FEW else None
        with self._reading() as rows:
            return {row.fingerprint for row in rows.finished(few)} & set(fingerprints)

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """Return the complete runs among these points, by fingerprint."""
        few = list(fingerprints) if len(fingerprints) <= _FEW else None
        with self._reading() as rows:
            wanted = set(fingerprints)
            found = {row.fingerprint: row for row in rows.finished(few) if row.fingerprint in wanted}
            run_ids = list({row.run_id for row in found.values()}) if few is not None else None
            scalars = _by_run(rows.metrics(run_ids, SCALARS))
            tags = _by_run(rows.tags(run_ids, STUDY_TAG))
        return {
            key: StoredRun(row.run_id, studies_of(tags[row.run_id]), scalars[row.run_id], row.artifacts, row.enough)
            for key, row in found.items()
        }

    def period_counts(self) -> set[int]:
        """Return the numbers of periods that complete runs have."""
        with self._reading() as rows:
            return {int(value) for (value,) in rows.distinct("task.periods") if value.isdecimal()}

    def newest_sweep(self, study: str) -> StoredRun | None:
        """Return the summary run of the last sweep of a study, if there is one."""
        with self._reading() as rows:
            return next((StoredRun(run_id, artifacts=uri) for run_id, uri in rows.sweeps(study)), None)

    def running(self) -> list[RunningRun]:
        """Return the RUNNING runs of points and sweeps."""
        with self._reading() as rows:
            return [RunningRun.of(tags) for tags in _by_run(rows.running()).values()]

    @contextmanager
    def _reading(self) -> Iterator[_Rows]:
        """Open a transaction, in which all rows are as they are at one moment."""
        path = sqlite_path(self._address.uri)
        if path and not path.exists():
            yield _Rows(None, self._address)
            return
        import sqlalchemy

        with ExitStack() as stack:
            with _translated_errors(self._address.uri):
                self._connections = self._connections or reading_engine(self._address.uri)
                connection = stack.enter_context(self._connections.connect())
                # Another process may be creating them right now.
                has_tables = set(sqlalchemy.inspect(connection).get_table_names()) >= _TABLES
            rows = _Rows(connection if has_tables else None, self._address)
            rows.check_experiment("experiment", self._address.experiment)
            yield rows


class _Rows:
    """Rows of the tables; none where there are no tables.

    Args:
        connection: None if there are no tables.
        address: of the store.
    """

    def __init__(self, connection: Connection | None, address: StoreAddress) -> None:
        self._connection = connection
        self._address = address

    def check_experiment(self, key: str, name: str) -> None:
        """Check that an experiment was not deleted.

        Args:
            key: the setting that names it.
            name: of the experiment.

        Raises:
            ConfigError: it was.
        """
        wanted = "select experiment_id from experiments where name = :name and lifecycle_stage = 'deleted'"
        for (experiment,) in self._select(wanted, name=name):
            raise deleted_experiment(key, name, self._address.uri, experiment)

    def revision(self) -> str:
        """Return the revision of the schema; empty if there are no tables."""
        return next((version for (version,) in self._select("select version_num from alembic_version")), "")

    def experiment_id(self) -> str | None:
        """Return the id of the experiment, if there is one."""
        found = self._select("select e.experiment_id from experiments e where e.name = :experiment")
        return str(found[0][0]) if found else None

    def finished(self, fingerprints: Sequence[str] | None) -> Iterable[_Finished]:
        """Return the complete runs of points; of all points if None."""
        if fingerprints is not None and not fingerprints:
            return []
        query = f"select r.run_uuid, r.artifact_uri, t.key, t.value {_joined('tags t')}"
        if fingerprints is None:
            also = f"substr(t.key, 1, {len(_PRECISION)}) = '{_PRECISION}'"
            found = self._select(f"{query} and (t.key = '{FINGERPRINT_TAG}' or {also})")
        else:
            query = f"{query} and (t.key = '{FINGERPRINT_TAG}' and t.value in :among or t.key in :names)"
            found = self._select(query, among=fingerprints, names=[f"{_PRECISION}{each}" for each in fingerprints])
        return [
            _Finished(run_id, uri, value, None)
            if key == FINGERPRINT_TAG
            else _Finished(run_id, uri, key.removeprefix(_PRECISION), enough(value))
            for run_id, uri, key, value in found
        ]

    def runs(self) -> Iterable[tuple[str, str, int, int, str]]:
        """Return (run id, name, start and end in milliseconds since 1970, URI of the artifacts) of complete runs."""
        return self._select(f"select r.run_uuid, r.name, r.start_time, r.end_time, r.artifact_uri {_RUNS}")

    def params(self) -> Iterable[tuple[str, str, str]]:
        """Return (run id, name, value) of the params of complete runs."""
        return self._values("params", None, "")

    def metrics(self, run_ids: Sequence[str] | None, names: Sequence[str] = ()) -> Iterable[tuple[str, str, float]]:
        """Return (run id, name, last value) of metrics, all if none are named; of all complete runs if None."""
        return self._values("latest_metrics", run_ids, "and v.key in :names" if names else "", names=names)

    def tags(self, run_ids: Sequence[str] | None, prefix: str = "") -> Iterable[tuple[str, str, str]]:
        """Return (run id, name, value) of the tags whose names begin with a prefix; of all complete runs if None."""
        condition = "and substr(v.key, 1, :length) = :prefix"
        return self._values("tags", run_ids, condition, prefix=prefix, length=len(prefix))

    def distinct(self, name: str) -> Iterable[tuple[str]]:
        """Return the values of a param that complete runs have."""
        return self._select(f"select distinct p.value {_joined('params p')} and p.key = '{name}'")

    def running(self) -> Iterable[tuple[str, str, str]]:
        """Return (run id, name, value) of the tags of RUNNING runs of points and sweeps."""
        query = """
            select r.run_uuid, t.key, t.value from runs r join tags t on t.run_uuid = r.run_uuid
            join experiments e on e.experiment_id = r.experiment_id
            where r.status = 'RUNNING' and r.lifecycle_stage = 'active' and e.name in (:experiment, :sweeps)
        """
        return self._select(query, sweeps=self._address.sweeps)

    def sweeps(self, study: str) -> Iterable[tuple[str, str]]:
        """Return (run id, URI of the artifacts) of the summary runs of the sweeps of a study, the last one first."""
        query = """
            select r.run_uuid, r.artifact_uri from runs r join tags t on t.run_uuid = r.run_uuid
            join experiments e on e.experiment_id = r.experiment_id
            where r.lifecycle_stage = 'active' and e.name = :sweeps and t.key = :tag and t.value = 'true'
            order by r.start_time desc
        """
        return self._select(query, sweeps=self._address.sweeps, tag=f"{STUDY_TAG}{study}")

    def counts(self) -> dict[tuple[str, str], int]:
        """Return numbers of runs by lifecycle stage (active, deleted) and status."""
        query = """
            select r.lifecycle_stage, r.status, count(*)
            from runs r join experiments e on e.experiment_id = r.experiment_id
            where e.name = :experiment group by r.lifecycle_stage, r.status
        """
        return {(stage, status): count for stage, status, count in self._select(query)}

    def _values(self, table: str, run_ids: Sequence[str] | None, condition: str, **values: Any) -> list[Any]:
        if run_ids is not None and not run_ids:
            return []
        among = "and r.run_uuid in :among" if run_ids is not None else ""
        query = f"select v.run_uuid, v.key, v.value {_joined(f'{table} v')} {among} {condition}"
        return self._select(query, among=run_ids, **values)

    def _select(self, query: str, **values: Any) -> list[Any]:
        import sqlalchemy

        if self._connection is None:
            return []
        values["experiment"] = self._address.experiment
        names = [name for name in values if f":{name}" in query]
        lists = [name for name in names if name in ("among", "names")]
        statement = sqlalchemy.text(query).bindparams(*(sqlalchemy.bindparam(name, expanding=True) for name in lists))
        with _translated_errors(self._address.uri):
            result = self._connection.execute(statement, {name: values[name] for name in names})
            # The driver's own tuples: SQLAlchemy's rows take three times as long.
            return list(result.cursor.fetchall())


def _by_run(rows: Iterable[tuple[str, str, Value]]) -> defaultdict[str, dict[str, Value]]:
    """Return values by run id and name; no values for other runs."""
    values: defaultdict[str, dict[str, Value]] = defaultdict(dict)
    for run_id, name, value in rows:
        values[run_id][name] = value
    return values


@contextmanager
def _translated_errors(uri: str) -> Iterator[None]:
    try:
        yield
    except Exception as error:
        raise as_tracking_error(uri, error) from error


def _joined(table: str) -> str:
    """Return the clause of the complete runs, joined with a table that has rows for each of them."""
    return _RUNS.replace("where", f"join {table} on {table[-1]}.run_uuid = r.run_uuid where")
