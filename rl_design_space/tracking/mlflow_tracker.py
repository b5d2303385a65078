"""Design points and sweeps as MLflow runs."""

from __future__ import annotations

import csv
import getpass
import hashlib
import os
import platform
import shutil
import subprocess
import time
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir
from typing import TYPE_CHECKING
from uuid import uuid4

from mlflow.entities import Metric, Param, RunTag
from mlflow.exceptions import MlflowException

import rl_design_space
from rl_design_space._paths import CONF
from rl_design_space.errors import ConfigError
from rl_design_space.tracking import record
from rl_design_space.tracking.claims import claims_at
from rl_design_space.tracking.index import finished_runs
from rl_design_space.tracking.store import connect, sqlite_path
from rl_design_space.tracking.tracker import StoredRun, SweepRecord

if TYPE_CHECKING:
    from mlflow import MlflowClient

    from rl_design_space.learning import LearningCurves
    from rl_design_space.sweep.plan import Plan, PlannedPoint
    from rl_design_space.tracking.options import MlflowTracking

#: MLflow refuses larger batches.
_METRICS_PER_BATCH = 1000
#: Tags of ours: the machine that wrote a run; what the process of a sweep claims; why a run is not complete.
_HOST_TAG, _SWEEP_TAG, _INCOMPLETE_TAG = "rl_design_space.host", "rl_design_space.sweep", "rl_design_space.incomplete"


class MlflowTracker:
    """Writes each point as one flat run; FINISHED is its commit mark.

    Raises:
        ConfigError: the store cannot be used.
    """

    def __init__(self, options: MlflowTracking, command: str) -> None:
        self._options = options
        self._client = connect(options.uri)
        self._points = _experiment(self._client, "experiment", options.experiment, options.uri)
        self._sweeps = _experiment(self._client, "sweeps", options.sweeps, options.uri)
        self._origin = _origin(command)
        self._claims = claims_at(_claims_path(options.uri))
        self._close_stale_runs()

    @property
    def location(self) -> str:
        """The store and the experiment in it."""
        return f"{self._options.uri}, experiment {self._options.experiment!r}"

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """The complete runs among these points, by fingerprint."""
        self._claims.forget()
        return self._finished(fingerprints)

    def claim(self, fingerprint: str) -> bool:
        """Take a point upon this process; False while another one has it."""
        return self._claims.take(fingerprint)

    def recorded_meanwhile(self, fingerprint: str) -> StoredRun | None:
        """The complete run of a point that has come to be since `finished` was last asked, if any."""
        if not self._claims.announced(fingerprint):
            return None
        return self._finished([fingerprint]).get(fingerprint)

    def release(self, fingerprint: str) -> None:
        """Give up a claim."""
        self._claims.release(fingerprint)

    def scalars(self, run: StoredRun) -> Mapping[str, float]:
        """The numbers that sum a stored point up."""
        metrics: Mapping[str, float] = self._client.get_run(run.run_id).data.metrics
        return metrics

    def record(self, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
        """Store a point's result; the run is FINISHED only when everything is in."""
        scalars = curves.scalars(planned.point.world.shape)
        started = int((time.time() - curves.seconds) * 1000)
        tags = {"fingerprint": planned.fingerprint, **_study_tags(planned.studies), **self._origin}
        run = self._client.create_run(self._points, start_time=started, tags=tags, run_name=planned.name)
        run_id = run.info.run_id
        try:
            metrics = [
                Metric(key=name, value=value, timestamp=started, step=step)
                for name, value, step in record.metrics(curves, scalars, self._options.curves)
            ]
            params = [Param(name, value) for name, value in record.params(planned).items()]
            for first in range(0, len(metrics), _METRICS_PER_BATCH - len(params)):
                batch = metrics[first : first + _METRICS_PER_BATCH - len(params)]
                self._client.log_batch(run_id, metrics=batch, params=params if first == 0 else ())
            with TemporaryDirectory() as folder:
                record.write_artifacts(Path(folder), planned, curves)
                self._client.log_artifacts(run_id, folder)
            self._claims.announce(planned.fingerprint)
            self._client.set_terminated(run_id, "FINISHED")
        except BaseException:
            self._client.set_terminated(run_id, "FAILED")
            raise
        return StoredRun(run_id, frozenset(planned.studies))

    def add_studies(self, run: StoredRun, studies: Sequence[str]) -> None:
        """Note that a stored point belongs to these studies as well."""
        new = set(studies) - run.studies
        if new:
            tags = [RunTag(key, value) for key, value in _study_tags(sorted(new)).items()]
            self._client.log_batch(run.run_id, tags=tags)

    def open_sweep(self, plan: Plan, command: str) -> SweepRecord:
        """Start the summary run of a sweep that a command runs."""
        claim = uuid4().hex
        self._claims.take(claim)
        tags = {
            **_study_tags(plan.studies),
            **self._origin,
            _SWEEP_TAG: claim,
            "mlflow.note.content": f"`{command}`",
        }
        run = self._client.create_run(self._sweeps, tags=tags, run_name=plan.name)
        summary = _MlflowSweep(self._client, run.info.run_id)
        summary.write_plan(plan)
        return summary

    def _finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        return finished_runs(self._client, self._options.uri, self._points, fingerprints)

    def _close_stale_runs(self) -> None:
        """Mark runs as KILLED whose process is gone: it was on this machine, and nobody claims what it was at."""
        running = f"attributes.status = 'RUNNING' and tags.`{_HOST_TAG}` = '{self._origin[_HOST_TAG]}'"
        for run in self._client.search_runs([self._points, self._sweeps], running):
            claim = run.data.tags.get("fingerprint") or run.data.tags.get(_SWEEP_TAG)
            if not claim or not self._claims.take(claim):
                continue
            # Asked again now that nobody can be writing to it: it may have ended in between.
            if self._client.get_run(run.info.run_id).info.status == "RUNNING":
                self._client.set_tag(run.info.run_id, _INCOMPLETE_TAG, "the process that wrote it has ended")
                self._client.set_terminated(run.info.run_id, "KILLED")
            self._claims.release(claim)


class _MlflowSweep:
    def __init__(self, client: MlflowClient, run_id: str) -> None:
        self._client = client
        self._run_id = run_id

    def write_plan(self, plan: Sequence[PlannedPoint]) -> None:
        columns = sorted({name for planned in plan for name in planned.parameters})
        rows = [{"fingerprint": planned.fingerprint, **planned.parameters} for planned in plan]
        self._write_table("plan.csv", ["fingerprint", *columns], rows)

    def close(self, status: str, counts: Mapping[str, int], failures: Mapping[str, str]) -> None:
        now = int(time.time() * 1000)
        metrics = [Metric(f"points/{name}", float(count), now, 0) for name, count in counts.items()]
        self._client.log_batch(self._run_id, metrics=metrics)
        if failures:
            rows = [{"command": command, "error": error} for command, error in failures.items()]
            self._write_table("failures.csv", ["command", "error"], rows)
        self._client.set_terminated(self._run_id, status)

    def _write_table(self, name: str, columns: list[str], rows: list[dict[str, str]]) -> None:
        with TemporaryDirectory() as folder:
            path = Path(folder) / name
            with path.open("w", newline="", encoding="utf-8") as file:
                writer = csv.DictWriter(file, columns)
                writer.writeheader()
                writer.writerows(rows)
            self._client.log_artifact(self._run_id, str(path))


def _experiment(client: MlflowClient, key: str, name: str, uri: str) -> str:
    """The experiment's id; artifacts of a SQLite store go into a folder beside it."""
    if known := client.get_experiment_by_name(name):
        if known.lifecycle_stage == "deleted":
            raise ConfigError.at(f"tracking.{key}", name, "was deleted in this store; restore it or use another name")
        return str(known.experiment_id)
    database = sqlite_path(uri)
    place = (database.parent / "artifacts" / name.replace(" ", "-")).as_uri() if database else None
    try:
        return str(client.create_experiment(name, artifact_location=place))
    except MlflowException:
        # Another process may have created it a moment ago.
        if known := client.get_experiment_by_name(name):
            return str(known.experiment_id)
        raise


def _claims_path(uri: str) -> Path:
    """Beside a SQLite database; for other stores, where all processes of the user on this machine find it."""
    if database := sqlite_path(uri):
        return database.with_name(f"{database.name}.claims")
    store = hashlib.sha256(uri.encode()).hexdigest()[:16]
    return Path(gettempdir()) / f"rl-design-space-{os.getuid()}" / f"{store}.claims"


def _study_tags(studies: Sequence[str]) -> dict[str, str]:
    return {f"{record.STUDY_TAG}{study}": "true" for study in studies}


def _origin(command: str) -> dict[str, str]:
    """Who recorded with which code; the client alone does not fill these in."""
    tags = {
        "rl_design_space.version": rl_design_space.__version__,
        "mlflow.source.name": command,
        "mlflow.source.type": "LOCAL",
        _HOST_TAG: platform.node(),
    }
    with suppress(OSError, KeyError):  # a user without a name
        tags["mlflow.user"] = getpass.getuser()
    checkout = CONF.parent
    if (checkout / ".git").exists() and shutil.which("git"):
        question = ["git", "-C", str(checkout), "rev-parse", "HEAD"]
        asked = subprocess.run(question, capture_output=True, text=True, check=False)
        if asked.returncode == 0:
            tags["mlflow.source.git.commit"] = asked.stdout.strip()
    return tags
