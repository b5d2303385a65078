"""Writing records with MLflow's client, step by step, continuing runs that were begun before."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from contextlib import suppress
from functools import cached_property, partial
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rl_design_space.tracking import values
from rl_design_space.tracking.artifacts import artifacts_folder, experiment_artifacts
from rl_design_space.tracking.client_runs import ClientRuns
from rl_design_space.tracking.content import content_of, sweep_note
from rl_design_space.tracking.locks import PointLocks
from rl_design_space.tracking.point_runs import PointRuns
from rl_design_space.tracking.record import ended_at, fingerprint_of
from rl_design_space.tracking.server_runs import ServerRuns
from rl_design_space.tracking.spool import CLOSE, OPEN, POINT, STUDIES, TIDY, Record, Spool
from rl_design_space.tracking.stale import DEAD, RunningRun
from rl_design_space.tracking.store_errors import DeletedExperimentError, deleted_experiment
from rl_design_space.tracking.tags import (
    FINGERPRINT_TAG,
    INCOMPLETE_TAG,
    NOTE_TAG,
    PRECISION_TAG,
    SPOOL_TAG,
    SWEEP_TAG,
    of_any_command,
)

if TYPE_CHECKING:
    from mlflow import MlflowClient
    from mlflow.entities import Run, RunInfo

#: Points that a server is sent at a time wait for the slowest of their batch: so many times as many are in flight.
_ROUNDS = 3


class ClientWriter:
    """Writes the records of a spool step by step, see `StoreWriter`; those of several points at a time into a server.

    The caller holds the lock of the spool. Then every RUNNING run that this spool has begun is either one to continue
    or one that no process writes to any more.

    Args:
        client: of the store.
        spool: where the records are.
        locks: of the points of the store.
    """

    def __init__(self, client: MlflowClient, spool: Spool, locks: PointLocks) -> None:
        self._client = client
        self._spool = spool
        self._locks = locks
        self._address = spool.address
        self._runs = (ServerRuns if self._address.is_server else ClientRuns)(client, self._address.uri)
        self.batch = _ROUNDS * self._runs.in_flight if self._address.is_server else 1
        self._identity, self._identities = spool.identity, spool.identities
        #: Names of records that the store may have, completely or in part: another process may have delivered those of
        #: the past, from this spool or another one.
        self._maybe_stored = set(spool.pending())
        self._writers: Mapping[str, Callable[[Record, bool], None]] = {
            OPEN: self._open_sweep,
            POINT: self._record_point,
            STUDIES: self._add_studies,
            CLOSE: self._close_sweep,
            TIDY: lambda record, maybe_stored: self.close_stale_runs(),
        }

    def write(self, records: Sequence[Record]) -> None:
        """Write records in this order, but points that follow each other at the same time.

        If one fails, others may have been written; all are looked up before they are written again.
        """
        names = {record.name for record in records}
        unsure = {record.name for record in records if not record.content.get("checked", True)} | self._maybe_stored
        self._maybe_stored |= names
        for kind, same in groupby(records, lambda record: record.kind):
            calls = [partial(self._writers[kind], record, record.name in unsure) for record in same]
            _run(calls, self._runs.in_flight if kind == POINT else 1)
        self._maybe_stored -= names

    def close_stale_runs(self) -> None:
        """Mark as KILLED the RUNNING runs that no process will finish."""
        for run in self._client.search_runs(self._usable, "attributes.status = 'RUNNING'"):
            self._kill_if_stale(run.info.run_id, RunningRun.of(run.data.tags))

    def close(self) -> None:
        """Close nothing: MLflow keeps its connections while the process lives."""

    def _kill_if_stale(self, run_id: str, run: RunningRun) -> None:
        if run.is_stale(self._spool, self._locks):
            self._client.set_tag(run_id, INCOMPLETE_TAG, DEAD)
            self._runs.end(run_id, "KILLED")

    def _record_point(self, record: Record, maybe_stored: bool) -> None:
        content, fingerprint = record.content, fingerprint_of(record)
        tags = of_any_command(content["tags"])
        found = self._point_runs.settle(fingerprint, tags) if maybe_stored else None
        if found and found.info.status == "FINISHED":
            return
        run = found.info if found else self._create(self._points, content, {FINGERPRINT_TAG: fingerprint})
        run_content = content_of(record, run.run_id)
        note = {NOTE_TAG: run_content.note}
        self._runs.log(run.run_id, content["started"], run_content.metrics, content["params"], note)
        self._runs.upload(run, run_content.artifacts)
        for key in {record.key, fingerprint}:
            self._locks.add_to_journal(key)
        self._runs.end(run.run_id, "FINISHED", ended_at(record))
        self._point_runs.settle(fingerprint, tags)

    def _add_studies(self, record: Record, maybe_stored: bool) -> None:
        for fingerprint, tags in record.content["tags"].items():
            if not self._point_runs.settle(fingerprint, tags):
                asked = f"attributes.status = 'FINISHED' and tags.`{PRECISION_TAG}.{fingerprint}` LIKE '%'"
                for run in self._client.search_runs([self._points], asked, max_results=1):
                    self._point_runs.settle(run.data.tags[FINGERPRINT_TAG], tags)

    def _open_sweep(self, record: Record, maybe_stored: bool) -> None:
        found = self._found(SWEEP_TAG, record.key, self._sweeps) if maybe_stored else None
        content = record.content
        run = found.info if found else self._create(self._sweeps, content, {SWEEP_TAG: record.key})
        self._runs.upload(run, record.files)
        self._kill_if_stale(run.run_id, RunningRun(self._identity, "", record.key))
        for experiment, views in ((self._points, content["views"]), (self._sweeps, content["sweep_views"])):
            for name, value in views.items():
                self._client.set_experiment_tag(experiment, name, value)

    def _close_sweep(self, record: Record, maybe_stored: bool) -> None:
        content = record.content
        found = self._found(SWEEP_TAG, record.key, self._sweeps)
        run = found.info if found else self._create(self._sweeps, content, {SWEEP_TAG: record.key})
        note = {NOTE_TAG: sweep_note(record, run.run_id)}
        self._runs.log(run.run_id, content["started"], content["metrics"], {}, note)
        self._runs.upload(run, record.files)
        self._runs.end(run.run_id, content["status"], content["ended"])

    @cached_property
    def _points(self) -> str:
        return self._experiment("experiment", self._address.experiment)

    @cached_property
    def _point_runs(self) -> PointRuns:
        return PointRuns(self._runs, self._points, self._identities)

    @cached_property
    def _sweeps(self) -> str:
        return self._experiment("sweeps", self._address.sweeps)

    @property
    def _usable(self) -> list[str]:
        """Ids of those of both experiments that were not deleted."""
        found = []
        for name in ("_points", "_sweeps"):
            with suppress(DeletedExperimentError):
                found.append(getattr(self, name))
        return found

    def _experiment(self, key: str, name: str) -> str:
        folder = artifacts_folder(self._address, self._spool.folder.parent)
        return experiment_id(self._client, self._address.uri, key, name, folder)

    def _create(self, experiment: str, content: Mapping[str, Any], tags: Mapping[str, str]) -> RunInfo:
        name, all_tags = values.run_name(content["name"]), {**content["tags"], **tags, SPOOL_TAG: self._identity}
        return self._runs.create(experiment, name, content["started"], all_tags)

    def _found(self, tag: str, value: str, experiment: str) -> Run | None:
        """Return the run of a sweep: a complete one, or one that this spool has begun."""
        runs = self._runs.find(experiment, tag, value)
        begun = [
            run for run in runs if run.info.status == "RUNNING" and run.data.tags.get(SPOOL_TAG) in self._identities
        ]
        return next((run for run in [*runs, *begun] if run in begun or run.info.status == "FINISHED"), None)


def experiment_id(client: MlflowClient, uri: str, key: str, name: str, artifacts: Path | None) -> str:
    """Return the id of an experiment, which is created if missing.

    Args:
        client: of the store.
        uri: of the store.
        key: the setting that names the experiment.
        name: of the experiment.
        artifacts: folder for its artifacts if it is created; None leaves that to the store.

    Raises:
        ConfigError: the experiment was deleted.
    """
    from mlflow.exceptions import MlflowException

    if known := client.get_experiment_by_name(name):
        if known.lifecycle_stage == "deleted":
            raise deleted_experiment(key, name, uri, known.experiment_id)
        return str(known.experiment_id)
    place = experiment_artifacts(artifacts, name) if artifacts else None
    try:
        return str(client.create_experiment(name, artifact_location=place))
    except MlflowException:
        # Another process may have created it a moment ago.
        if known := client.get_experiment_by_name(name):
            return str(known.experiment_id)
        raise


def _run(calls: Sequence[Callable[[], None]], in_flight: int) -> None:
    """Run functions, several at a time; begin no other one after an exception, and raise it when all have ended."""
    if in_flight == 1:
        for call in calls:
            call()
        return
    with ThreadPoolExecutor(in_flight) as pool:  # new threads, which have the priority of this one
        futures = [pool.submit(call) for call in calls]
        wait(futures, return_when=FIRST_EXCEPTION)
        pool.shutdown(cancel_futures=True)
    for future in futures:
        if not future.cancelled():
            future.result()
