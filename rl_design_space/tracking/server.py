"""Queries of an MLflow tracking server, over HTTP."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import SCALARS
from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.connection import connect
from rl_design_space.tracking.found_run import FoundRun, RunCounts
from rl_design_space.tracking.server_search import search_many, search_runs
from rl_design_space.tracking.stale import RunningRun
from rl_design_space.tracking.store_errors import (
    access_error,
    as_tracking_error,
    deleted_experiment,
    is_transient,
    missing_experiment,
)
from rl_design_space.tracking.tags import PRECISION_TAG, STUDY_TAG, fingerprints_of, studies_of
from rl_design_space.tracking.tracker import StoredRun

if TYPE_CHECKING:
    from mlflow import MlflowClient
    from mlflow.entities import Run

#: Up to so many points are searched for one by one; for more, all runs are read.
_FEW = 20
_RUNS_PER_PAGE = 1000
#: Maximum number of different numbers of periods that are asked for.
_MOST_COUNTS = 30
_COMPLETE = "attributes.status = 'FINISHED'"


class ServerQueries:
    """Queries of a tracking server, see `Queries`.

    Args:
        address: of the store.
    """

    def __init__(self, address: StoreAddress) -> None:
        self._address = address
        self._connected: MlflowClient | None = None

    @property
    def experiment(self) -> str:
        """Id of the experiment."""
        with _translated_errors(self._address):
            experiment = self._experiment()
            if experiment is None:
                raise missing_experiment(self._address)
            return experiment

    def runs(self) -> list[FoundRun]:
        """Return all complete runs."""
        with _translated_errors(self._address):
            experiment = self._experiment()
            return self._every(experiment) if experiment else []

    def counts(self) -> RunCounts:
        """Count the runs by status."""
        from mlflow.entities import ViewType

        with _translated_errors(self._address):
            experiment = self._experiment()
            found = search_all(self._client(), experiment, "", ViewType.ALL) if experiment else []
            return RunCounts.of(Counter((run.info.lifecycle_stage, run.info.status) for run in found))

    def check(self, *, sweeps: bool) -> str:
        """Check the experiment of the sweeps, if it is needed; all other queries check the other one."""
        if sweeps:
            with _translated_errors(self._address):
                self._known("sweeps", self._address.sweeps)
        return ""

    def recorded(self, fingerprints: Collection[str]) -> set[str]:
        """Return those of these points that have a complete run."""
        return set(self.finished(fingerprints))

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """Return the complete runs among these points, by fingerprint."""
        with _translated_errors(self._address):
            experiment = self._experiment()
            if experiment is None:
                return {}
            if len(fingerprints) <= _FEW:
                runs = [run for each in fingerprints for run in self._of_point(experiment, each)]
            else:
                runs = self._every(experiment)
            found = [pair for run in runs for pair in _stored(run)]
        wanted_points = set(fingerprints)
        return {fingerprint: run for fingerprint, run in found if fingerprint in wanted_points}

    def period_counts(self) -> set[int]:
        """Return the numbers of periods that complete runs have: each request finds another one."""
        with _translated_errors(self._address):
            experiment = self._experiment()
            found: list[int] = []
            while experiment and len(found) < _MOST_COUNTS:
                others = [f"params.`task.periods` != '{value}'" for value in found or [0]]
                run = next(search_runs(self._client(), experiment, " and ".join([_COMPLETE, *others]), 1), None)
                if run is None or not run.params["task.periods"].isdecimal():
                    break
                found.append(int(run.params["task.periods"]))
        return set(found)

    def newest_sweep(self, study: str) -> StoredRun | None:
        """Return the summary run of the last sweep of a study, if there is one."""
        wanted, newest = f"tags.`{STUDY_TAG}{study}` = 'true'", ["attributes.start_time DESC"]
        with _translated_errors(self._address):
            sweeps = self._client().get_experiment_by_name(self._address.sweeps)
            ids = [sweeps.experiment_id] if sweeps else []
            found = self._client().search_runs(ids, wanted, max_results=1, order_by=newest) if ids else []
            return next((StoredRun(run.info.run_id, artifacts=run.info.artifact_uri) for run in found), None)

    def running(self) -> list[RunningRun]:
        """Return the RUNNING runs of points and sweeps."""
        with _translated_errors(self._address):
            names = (self._address.experiment, self._address.sweeps)
            known = [self._client().get_experiment_by_name(name) for name in names]
            ids = [each.experiment_id for each in known if each]
            runs = [run for each in ids for run in search_all(self._client(), each, "attributes.status = 'RUNNING'")]
        return [RunningRun.of(run.data.tags) for run in runs]

    def _experiment(self) -> str | None:
        return self._known("experiment", self._address.experiment)

    def _known(self, key: str, name: str) -> str | None:
        """Return the id of an experiment, if there is one; `key` is the setting that names it."""
        known = self._client().get_experiment_by_name(name)
        if known and known.lifecycle_stage == "deleted":
            raise deleted_experiment(key, name, self._address.uri, known.experiment_id)
        return str(known.experiment_id) if known else None

    def _of_point(self, experiment: str, fingerprint: str) -> list[FoundRun]:
        """Return the complete runs of a point."""
        own = list(self._search(experiment, f"{_COMPLETE} and tags.fingerprint = '{fingerprint}'"))
        asked = f"{_COMPLETE} and tags.`{PRECISION_TAG}.{fingerprint}` LIKE '%'"
        return own or list(self._search(experiment, asked))

    def _every(self, experiment: str) -> list[FoundRun]:
        return search_many(self._client(), experiment, _COMPLETE)

    def _search(self, experiment: str, filter_: str) -> Iterator[FoundRun]:
        return search_runs(self._client(), experiment, filter_, _RUNS_PER_PAGE)

    def _client(self) -> MlflowClient:
        self._connected = self._connected or connect(self._address.uri)
        return self._connected


def search_all(client: MlflowClient, experiment: str, filter_: str, view: int = 1) -> Iterable[Run]:
    """Yield all runs of an experiment that match a filter, page by page.

    Args:
        client: of the store.
        experiment: id of the experiment.
        filter_: a filter of MLflow's search; empty for all runs.
        view: an MLflow `ViewType`; active runs by default.
    """
    token = None
    while True:
        page = client.search_runs([experiment], filter_, view, max_results=_RUNS_PER_PAGE, page_token=token)
        yield from page
        token = page.token
        if not token:
            return


@contextmanager
def _translated_errors(address: StoreAddress) -> Iterator[None]:
    """Translate transient errors and access errors; others are raised as they are."""
    try:
        yield
    except Exception as error:
        if isinstance(error, ConfigError) or not (is_transient(error) or access_error(address.uri, error)):
            raise
        raise as_tracking_error(address.uri, error) from error


def _stored(run: FoundRun) -> Iterator[tuple[str, StoredRun]]:
    """Yield a run by the fingerprints of the points whose result it holds."""
    scalars = {name: value for name, value in run.metrics.items() if name in SCALARS}
    for fingerprint, enough in fingerprints_of(run.tags).items():
        yield fingerprint, StoredRun(run.run_id, studies_of(run.tags), scalars, run.artifacts, enough)
