"""Design points and sweeps as MLflow runs."""

from __future__ import annotations

import csv
import getpass
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from mlflow.entities import Metric, Param, RunTag
from mlflow.exceptions import MlflowException

import rl_design_space
from rl_design_space._paths import CONF
from rl_design_space.errors import ConfigError
from rl_design_space.tracking import record
from rl_design_space.tracking.read import finished_runs
from rl_design_space.tracking.store import connect, sqlite_path
from rl_design_space.tracking.tracker import StoredRun, SweepRecord

if TYPE_CHECKING:
    from mlflow import MlflowClient

    from rl_design_space.learning import LearningCurves
    from rl_design_space.sweep.plan import PlannedPoint
    from rl_design_space.sweep.study import Study
    from rl_design_space.tracking.options import MlflowTracking

#: MLflow refuses larger batches.
_METRICS_PER_BATCH = 1000


class MlflowTracker:
    """Writes each point as one flat run; FINISHED is its commit mark.

    Raises:
        ConfigError: the store cannot be used.
    """

    def __init__(self, options: MlflowTracking) -> None:
        self._options = options
        self._client = connect(options.uri)
        self._points = _experiment(self._client, "experiment", options.experiment, options.uri)
        self._sweeps = _experiment(self._client, "sweeps", options.sweeps, options.uri)
        self._origin = _origin()

    @property
    def location(self) -> str:
        """The store and the experiment in it."""
        return f"{self._options.uri}, experiment {self._options.experiment!r}"

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """The complete runs among these points, by fingerprint."""
        return finished_runs(self._client, self._points, fingerprints)

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
            self._client.set_terminated(run_id, "FINISHED")
        except BaseException:
            self._client.set_terminated(run_id, "FAILED")
            raise
        return StoredRun(run_id, scalars, frozenset(planned.studies))

    def add_studies(self, run: StoredRun, studies: Sequence[str]) -> None:
        """Note that a stored point belongs to these studies as well."""
        new = set(studies) - run.studies
        if new:
            tags = [RunTag(key, value) for key, value in _study_tags(sorted(new)).items()]
            self._client.log_batch(run.run_id, tags=tags)

    def open_sweep(self, study: Study) -> SweepRecord:
        """Start the summary run of a sweep."""
        tags = {**_study_tags([study.name]), **self._origin, "mlflow.note.content": f"`{study.command}`"}
        run = self._client.create_run(self._sweeps, tags=tags, run_name=study.name)
        summary = _MlflowSweep(self._client, run.info.run_id)
        summary.write_plan(study.plan)
        return summary


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


def _study_tags(studies: Sequence[str]) -> dict[str, str]:
    return {f"{record.STUDY_TAG}{study}": "true" for study in studies}


def _origin() -> dict[str, str]:
    """Who recorded with which code; the client alone does not fill these in."""
    tags = {
        "rl_design_space.version": rl_design_space.__version__,
        "mlflow.source.name": shlex.join(["rl-design-space", *sys.argv[1:]]),
        "mlflow.source.type": "LOCAL",
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
