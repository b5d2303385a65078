"""Writing records into an MLflow tracking store, each exactly once, however often it is attempted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from rl_design_space.tracking.address import StoreAddress, sqlite_path
from rl_design_space.tracking.content import content_of
from rl_design_space.tracking.locks import PointLocks
from rl_design_space.tracking.spool import CLOSE, OPEN, POINT, STUDIES, TIDY, Record, Spool, point_name
from rl_design_space.tracking.store_errors import deleted_experiment
from rl_design_space.tracking.tags import FINGERPRINT_TAG, INCOMPLETE_TAG, SPOOL_TAG, STUDY_TAG, SWEEP_TAG

if TYPE_CHECKING:
    from mlflow import MlflowClient
    from mlflow.entities import Run

#: MLflow refuses larger batches.
_BATCH = 1000
_NOTE_TAG = "mlflow.note.content"


class StoreWriter:
    """Writes the records of a spool into its tracking store.

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
        self._identity = spool.identity
        self._writers: Mapping[str, Callable[[Record, bool], None]] = {
            OPEN: self._open_sweep,
            POINT: self._record_point,
            STUDIES: self._add_studies,
            CLOSE: self._close_sweep,
            TIDY: lambda record, maybe_stored: self.close_stale_runs(),
        }

    def write(self, record: Record, maybe_stored: bool) -> None:
        """Write a record.

        Args:
            record: to write.
            maybe_stored: whether the store may have it already, or a part of it.

        Raises:
            Exception: whatever MLflow raises.
        """
        self._writers[record.kind](record, maybe_stored)

    def close_stale_runs(self) -> None:
        """Mark as KILLED the runs that this spool has begun and no process will finish.

        Those are runs of points whose record is gone, and summary runs of sweeps that have died.
        """
        for run in self._search(f"tags.`{SPOOL_TAG}` = '{self._identity}' and attributes.status = 'RUNNING'"):
            if sweep := run.data.tags.get(SWEEP_TAG):
                if self._spool.has(Record(CLOSE, sweep, {}).name) or not self._locks.acquire(sweep):
                    continue
                self._locks.release(sweep)
            elif self._spool.has(point_name(run.data.tags.get(FINGERPRINT_TAG, ""))):
                continue
            self._client.set_tag(run.info.run_id, INCOMPLETE_TAG, "the process that wrote it has ended")
            self._client.set_terminated(run.info.run_id, "KILLED")

    def _record_point(self, record: Record, maybe_stored: bool) -> None:
        content = record.content
        found = self._found(FINGERPRINT_TAG, record.key, self._points) if maybe_stored else None
        if found and found.info.status == "FINISHED":
            studies = {name: value for name, value in content["tags"].items() if name.startswith(STUDY_TAG)}
            self._tag(found.info.run_id, studies)
            return
        run_id = found.info.run_id if found else self._create(self._points, content, {FINGERPRINT_TAG: record.key})
        run_content = content_of(record)
        self._log(run_id, content["started"], run_content.metrics, content["params"])
        self._log_artifacts(run_id, run_content.artifacts)
        self._locks.add_to_journal(record.key)
        self._client.set_terminated(run_id, "FINISHED")

    def _add_studies(self, record: Record, maybe_stored: bool) -> None:
        for fingerprint, tags in record.content["tags"].items():
            if run := self._found(FINGERPRINT_TAG, fingerprint, self._points):
                self._tag(run.info.run_id, tags)

    def _open_sweep(self, record: Record, maybe_stored: bool) -> None:
        found = self._found(SWEEP_TAG, record.key, self._sweeps) if maybe_stored else None
        content = record.content
        run_id = found.info.run_id if found else self._create(self._sweeps, content, {SWEEP_TAG: record.key})
        self._log_artifacts(run_id, record.files)
        for experiment, views in ((self._points, content["views"]), (self._sweeps, content["sweep_views"])):
            for name, value in views.items():
                self._client.set_experiment_tag(experiment, name, value)

    def _close_sweep(self, record: Record, maybe_stored: bool) -> None:
        content = record.content
        found = self._found(SWEEP_TAG, record.key, self._sweeps)
        run_id = found.info.run_id if found else self._create(self._sweeps, content, {SWEEP_TAG: record.key})
        self._log(run_id, content["started"], content["metrics"], {})
        self._log_artifacts(run_id, record.files)
        self._tag(run_id, {_NOTE_TAG: content["note"]})
        self._client.set_terminated(run_id, content["status"], content["ended"])

    @cached_property
    def _points(self) -> str:
        return self._experiment("experiment", self._address.experiment)

    @cached_property
    def _sweeps(self) -> str:
        return self._experiment("sweeps", self._address.sweeps)

    def _experiment(self, key: str, name: str) -> str:
        return experiment_id(self._client, key, name, artifacts_folder(self._address, self._spool.folder.parent))

    def _create(self, experiment: str, content: Mapping[str, Any], tags: Mapping[str, str]) -> str:
        run = self._client.create_run(
            experiment,
            start_time=content["started"],
            run_name=content["name"],
            tags={**content["tags"], **tags, SPOOL_TAG: self._identity},
        )
        return str(run.info.run_id)

    def _found(self, tag: str, value: str, experiment: str) -> Run | None:
        """Return the run of a point or sweep: a complete one, or one that this spool has begun."""
        runs = self._client.search_runs([experiment], f"tags.`{tag}` = '{value}'")
        begun = [run for run in runs if run.info.status == "RUNNING" and run.data.tags.get(SPOOL_TAG) == self._identity]
        return next((run for run in [*runs, *begun] if run in begun or run.info.status == "FINISHED"), None)

    def _search(self, filter_: str) -> Sequence[Run]:
        runs: Sequence[Run] = self._client.search_runs([self._points, self._sweeps], filter_)
        return runs

    def _tag(self, run_id: str, tags: Mapping[str, str]) -> None:
        from mlflow.entities import RunTag

        if tags:
            self._client.log_batch(run_id, tags=[RunTag(name, value) for name, value in tags.items()])

    def _log(
        self, run_id: str, timestamp: int, metrics: Sequence[tuple[str, float, int]], params: Mapping[str, str]
    ) -> None:
        """Log params and metrics; repeating it changes nothing, because all timestamps are equal."""
        from mlflow.entities import Metric, Param

        points = [Metric(name, value, timestamp, step) for name, value, step in metrics]
        choices = [Param(name, value) for name, value in params.items()]
        room = _BATCH - len(choices)
        self._client.log_batch(run_id, metrics=points[:room], params=choices)
        for first in range(room, len(points), _BATCH):
            self._client.log_batch(run_id, metrics=points[first : first + _BATCH])

    def _log_artifacts(self, run_id: str, artifacts: Mapping[str, bytes]) -> None:
        if not artifacts:
            return
        with TemporaryDirectory() as folder:
            for name, content in artifacts.items():
                (Path(folder) / name).write_bytes(content)
            self._client.log_artifacts(run_id, folder)


def artifacts_folder(address: StoreAddress, spools: Path) -> Path | None:
    """Return where the artifacts of a store go.

    Args:
        address: of the store.
        spools: folder of all spools.

    Returns:
        A folder beside a SQLite database. For any other database, one beside the spools: by default, MLflow would use a
        folder in the working directory. None for a server, which has its own place.
    """
    if address.is_server:
        return None
    return (sqlite_path(address.uri) or spools).parent / "artifacts"


def experiment_id(client: MlflowClient, key: str, name: str, artifacts: Path | None) -> str:
    """Return the id of an experiment, which is created if missing.

    Args:
        client: of the store.
        key: the setting that names the experiment.
        name: of the experiment.
        artifacts: folder for its artifacts if it is created; None leaves that to the store.

    Raises:
        ConfigError: the experiment was deleted.
    """
    from mlflow.exceptions import MlflowException

    if known := client.get_experiment_by_name(name):
        if known.lifecycle_stage == "deleted":
            raise deleted_experiment(key, name)
        return str(known.experiment_id)
    place = (artifacts / name.replace(" ", "-")).as_uri() if artifacts else None
    try:
        return str(client.create_experiment(name, artifact_location=place))
    except MlflowException:
        # Another process may have created it a moment ago.
        if known := client.get_experiment_by_name(name):
            return str(known.experiment_id)
        raise
