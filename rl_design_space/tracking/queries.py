"""Asking a tracking store which points it has."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import SCALARS
from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.connection import connect
from rl_design_space.tracking.database import Database
from rl_design_space.tracking.record import FINGERPRINT_TAG, SPOOL_TAG, STUDY_TAG, SWEEP_TAG
from rl_design_space.tracking.store_errors import deleted_experiment, denial, passes, translated
from rl_design_space.tracking.tracker import StoredRun

if TYPE_CHECKING:
    from mlflow import MlflowClient
    from mlflow.entities import Run

#: Up to so many points are asked for by their fingerprints; above, all runs are read.
_FEW = 20
_RUNS_PER_PAGE = 1000
_COMPLETE = "attributes.status = 'FINISHED'"


@dataclass(frozen=True)
class Found:
    """A complete run, with everything that is known of it but its curves and files.

    Attributes:
        run_id: its id.
        name: what was asked for beside the defaults.
        started: milliseconds since 1970.
        ended: milliseconds since 1970.
        artifacts: where the store keeps its files.
        params: every choice.
        metrics: last values.
        tags: all.
    """

    run_id: str
    name: str
    started: int
    ended: int
    artifacts: str
    params: dict[str, str] = field(default_factory=dict)
    metrics: dict[str, float] = field(default_factory=dict)
    tags: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Counted:
    """Numbers of runs of an experiment.

    Attributes:
        finished: complete ones.
        others: by status.
        deleted: those that somebody has deleted.
    """

    finished: int
    others: dict[str, int]
    deleted: int


class Source(Protocol):
    """What a store has of an experiment."""

    @property
    def experiment(self) -> str:
        """Id of the experiment.

        Raises:
            ConfigError: there is none of that name.
        """
        ...

    def runs(self) -> list[Found]:
        """All complete runs.

        Raises:
            ConfigError: the store is of no use.
            StoreUnavailableError: it cannot be reached at the moment.
        """
        ...

    def counted(self) -> Counted:
        """How many runs of each kind there are."""
        ...

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """The complete runs among these points, by fingerprint.

        Raises:
            ConfigError: the store is of no use.
            StoreUnavailableError: it cannot be reached at the moment.
        """
        ...

    def begun(self, spool: str) -> list[str]:
        """Fingerprints of points and ids of sweeps that a spool has begun runs of, which are RUNNING still."""
        ...


def source_of(address: StoreAddress) -> Source:
    """A way to ask a store. A database is asked directly: through MLflow, 10,000 runs take 20 seconds."""
    return ServerSource(address) if address.is_server else DatabaseSource(address)


class DatabaseSource:
    """A database of MLflow; a SQLite file that does not exist holds nothing."""

    def __init__(self, address: StoreAddress) -> None:
        self._address = address
        self._database = Database(address)

    @property
    def experiment(self) -> str:
        """Id of the experiment."""
        with self._database.reading() as rows:
            return _known(rows.experiment_id(), self._address)

    def runs(self) -> list[Found]:
        """All complete runs."""
        with self._database.reading() as rows:
            found = {about[0]: Found(*about) for about in rows.about(None)}
            for run_id, name, value in rows.params(None):
                found[run_id].params[name] = value
            for run_id, name, number in rows.metrics(None):
                found[run_id].metrics[name] = number
            for run_id, name, value in rows.tags(None):
                found[run_id].tags[name] = value
        return list(found.values())

    def counted(self) -> Counted:
        """How many runs of each kind there are."""
        with self._database.reading() as rows:
            return _counted(rows.count())

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """The complete runs among these points, by fingerprint."""
        few = list(fingerprints) if len(fingerprints) <= _FEW else None
        with self._database.reading() as rows:
            asked = set(fingerprints)
            wanted = {run_id: (key, place) for run_id, key, place in rows.finished(few) if key in asked}
            runs = list(wanted) if few is not None else None
            scalars: dict[str, dict[str, float]] = {}
            for run_id, name, value in rows.metrics(runs, SCALARS):
                scalars.setdefault(run_id, {})[name] = value
            studies: dict[str, set[str]] = {}
            for run_id, name, _ in rows.tags(runs, STUDY_TAG):
                studies.setdefault(run_id, set()).add(name.removeprefix(STUDY_TAG))
        return {
            key: StoredRun(run_id, frozenset(studies.get(run_id, ())), scalars.get(run_id, {}), place)
            for run_id, (key, place) in wanted.items()
        }

    def begun(self, spool: str) -> list[str]:
        """Fingerprints of points and ids of sweeps that a spool has begun runs of, which are RUNNING still."""
        with self._database.reading() as rows:
            return rows.begun(spool)


class ServerSource:
    """A tracking server, over HTTP."""

    def __init__(self, address: StoreAddress) -> None:
        self._address = address
        self._connected: MlflowClient | None = None

    @property
    def experiment(self) -> str:
        """Id of the experiment."""
        with _told_when_unavailable(self._address):
            return _known(self._experiment(), self._address)

    def runs(self) -> list[Found]:
        """All complete runs."""
        with _told_when_unavailable(self._address):
            experiment = self._experiment()
            return [_found(run) for run in pages(self._client(), experiment, _COMPLETE)] if experiment else []

    def counted(self) -> Counted:
        """How many runs of each kind there are."""
        from mlflow.entities import ViewType

        with _told_when_unavailable(self._address):
            experiment = self._experiment()
            found = pages(self._client(), experiment, "", ViewType.ALL) if experiment else []
            return _counted(Counter((run.info.lifecycle_stage, run.info.status) for run in found))

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """The complete runs among these points, by fingerprint."""
        with _told_when_unavailable(self._address):
            experiment = self._experiment()
            if experiment is None:
                return {}
            few = len(fingerprints) <= _FEW
            filters = [f"{_COMPLETE} and tags.fingerprint = '{each}'" for each in fingerprints] if few else [_COMPLETE]
            found = [_stored(run) for wanted in filters for run in pages(self._client(), experiment, wanted)]
        asked = set(fingerprints)
        return {fingerprint: run for fingerprint, run in found if fingerprint in asked}

    def begun(self, spool: str) -> list[str]:
        """Fingerprints of points and ids of sweeps that a spool has begun runs of, which are RUNNING still."""
        with _told_when_unavailable(self._address):
            names = (self._address.experiment, self._address.sweeps)
            known = [self._client().get_experiment_by_name(name) for name in names]
            wanted = f"attributes.status = 'RUNNING' and tags.`{SPOOL_TAG}` = '{spool}'"
            runs = [run for each in known if each for run in pages(self._client(), each.experiment_id, wanted)]
        return [run.data.tags.get(FINGERPRINT_TAG) or run.data.tags.get(SWEEP_TAG, "") for run in runs]

    def _experiment(self) -> str | None:
        known = self._client().get_experiment_by_name(self._address.experiment)
        if known and known.lifecycle_stage == "deleted":
            raise deleted_experiment("experiment", self._address.experiment)
        return str(known.experiment_id) if known else None

    def _client(self) -> MlflowClient:
        self._connected = self._connected or connect(self._address.uri)
        return self._connected


def pages(client: MlflowClient, experiment: str, wanted: str, kind: int = 1) -> Iterable[Run]:
    """All runs of an experiment that a filter of MLflow finds, of a kind of its `ViewType`; active ones if not told."""
    token = None
    while True:
        page = client.search_runs([experiment], wanted, kind, max_results=_RUNS_PER_PAGE, page_token=token)
        yield from page
        token = page.token
        if not token:
            return


def _known(experiment: str | None, address: StoreAddress) -> str:
    if experiment is None:
        raise ConfigError.at("tracking.experiment", address.experiment, f"there is no such experiment in {address.uri}")
    return experiment


@contextmanager
def _told_when_unavailable(address: StoreAddress) -> Iterator[None]:
    try:
        yield
    except Exception as error:
        if isinstance(error, ConfigError) or not (passes(error) or denial(address.uri, error)):
            raise
        raise translated(address.uri, error) from error


def _counted(runs: Mapping[tuple[str, str], int]) -> Counted:
    """From numbers of runs by stage of life and status."""
    active = {status: count for (stage, status), count in runs.items() if stage == "active"}
    deleted = sum(count for (stage, _), count in runs.items() if stage == "deleted")
    return Counted(active.pop("FINISHED", 0), active, deleted)


def _found(run: Run) -> Found:
    info, data = run.info, run.data
    about = (info.run_id, info.run_name, info.start_time, info.end_time, info.artifact_uri)
    return Found(*about, data.params, data.metrics, data.tags)


def _stored(run: Run) -> tuple[str, StoredRun]:
    studies = frozenset(tag.removeprefix(STUDY_TAG) for tag in run.data.tags if tag.startswith(STUDY_TAG))
    scalars = {name: value for name, value in run.data.metrics.items() if name in SCALARS}
    place = run.info.artifact_uri
    return run.data.tags.get(FINGERPRINT_TAG, ""), StoredRun(run.info.run_id, studies, scalars, place)
