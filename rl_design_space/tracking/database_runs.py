"""Runs in the tables of MLflow's database, written in one transaction."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Table, case, delete, insert, select, update

from rl_design_space.tracking.artifacts import experiment_artifacts, write_artifacts
from rl_design_space.tracking.bulk_insert import insert_rows
from rl_design_space.tracking.database_tables import (
    EXPERIMENT_TAGS,
    EXPERIMENTS,
    LATEST_METRICS,
    METRICS,
    PARAMS,
    RUNS,
    TAGS,
)
from rl_design_space.tracking.store_errors import deleted_experiment

#: Name, value and step of a metric.
Metric = tuple[str, float, int]


@dataclass(frozen=True)
class NewRun:
    """A run as MLflow's client would have written it.

    Attributes:
        run_id: 32 hexadecimal digits.
        name: of the run.
        started: milliseconds since 1970; timestamp of the metrics, too.
        status: RUNNING if `ended` is None.
        ended: milliseconds since 1970.
        tags: values by name.
        params: values by name.
        metrics: at most one value for a name and step.
        artifacts: contents of files by name.
    """

    run_id: str
    name: str
    started: int
    status: str
    ended: int | None
    tags: Mapping[str, str]
    params: Mapping[str, str] = field(default_factory=dict)
    metrics: Sequence[Metric] = ()
    artifacts: Mapping[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True)
class Experiment:
    """An experiment.

    Attributes:
        id: its id.
        artifacts: URI of the folder of its artifacts.
    """

    id: int
    artifacts: str


class DatabaseRuns:
    """The runs of a database, as one transaction sees and writes them.

    Args:
        connection: in a transaction that no other process writes beside.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def experiment(self, key: str, name: str, artifacts: Path) -> Experiment:
        """Return an experiment, which is created if missing.

        Args:
            key: the setting that names the experiment.
            name: of the experiment.
            artifacts: folder of the artifacts of all experiments, if it is created.

        Raises:
            ConfigError: the experiment was deleted.
        """
        columns = (EXPERIMENTS.c.experiment_id, EXPERIMENTS.c.artifact_location, EXPERIMENTS.c.lifecycle_stage)
        wanted = select(*columns).where(EXPERIMENTS.c.name == name)
        if (found := self._connection.execute(wanted).first()) is None:
            now = int(time.time() * 1000)
            row = {
                "name": name,
                "artifact_location": experiment_artifacts(artifacts, name),
                "lifecycle_stage": "active",
                "creation_time": now,
                "last_update_time": now,
            }
            self._connection.execute(insert(EXPERIMENTS).values(row))
            found = self._connection.execute(wanted).one()
        if found.lifecycle_stage == "deleted":
            raise deleted_experiment(key, name, str(self._connection.engine.url), found.experiment_id)
        return Experiment(found.experiment_id, found.artifact_location)

    def set_experiment_tags(self, experiment: Experiment, tags: Mapping[str, str]) -> None:
        """Set tags of an experiment."""
        self._replace(EXPERIMENT_TAGS, "experiment_id", experiment.id, tags)

    def find(self, experiment: Experiment, tag: str, values: Collection[str], *, finished: bool) -> dict[str, str]:
        """Return the ids of active runs by the value of a tag.

        Args:
            experiment: of the runs.
            tag: name of the tag.
            values: of the tag.
            finished: whether to leave out incomplete runs; otherwise, those that are complete go first.
        """
        of_run = RUNS.join(TAGS, TAGS.c.run_uuid == RUNS.c.run_uuid)
        query = select(TAGS.c.value, RUNS.c.run_uuid).select_from(of_run)
        query = query.where(TAGS.c.key == tag, TAGS.c.value.in_(values), RUNS.c.experiment_id == experiment.id)
        query = query.where(RUNS.c.lifecycle_stage == "active")
        if finished:
            query = query.where(RUNS.c.status == "FINISHED")
        # The last one that is found for a value wins.
        query = query.order_by(case((RUNS.c.status == "FINISHED", 1), else_=0))
        return {row.value: row.run_uuid for row in self._connection.execute(query)}

    def having(self, experiment: Experiment, tags: Collection[str]) -> dict[str, str]:
        """Return the ids of complete runs by the name of a tag that they have, whatever its value."""
        of_run = RUNS.join(TAGS, TAGS.c.run_uuid == RUNS.c.run_uuid)
        query = select(TAGS.c.key, RUNS.c.run_uuid).select_from(of_run).where(TAGS.c.key.in_(tags))
        query = query.where(RUNS.c.experiment_id == experiment.id, RUNS.c.lifecycle_stage == "active")
        found = self._connection.execute(query.where(RUNS.c.status == "FINISHED"))
        return {row.key: row.run_uuid for row in found}

    def existing(self, run_ids: Collection[str]) -> set[str]:
        """Return those of these run ids of which there are runs, deleted ones included."""
        return set(self._connection.scalars(select(RUNS.c.run_uuid).where(RUNS.c.run_uuid.in_(run_ids))))

    def running(self, experiments: Iterable[Experiment]) -> dict[str, dict[str, str]]:
        """Return the tags of the RUNNING runs of experiments, by run id."""
        of_run = RUNS.join(TAGS, TAGS.c.run_uuid == RUNS.c.run_uuid)
        query = select(RUNS.c.run_uuid, TAGS.c.key, TAGS.c.value).select_from(of_run)
        query = query.where(RUNS.c.status == "RUNNING", RUNS.c.lifecycle_stage == "active")
        query = query.where(RUNS.c.experiment_id.in_([experiment.id for experiment in experiments]))
        found: dict[str, dict[str, str]] = {}
        for run_id, name, value in self._connection.execute(query):
            found.setdefault(run_id, {})[name] = value
        return found

    def add(self, experiment: Experiment, runs: Sequence[NewRun]) -> None:
        """Write runs with all that they hold; their files are written first."""
        uris = {run.run_id: f"{experiment.artifacts.rstrip('/')}/{run.run_id}/artifacts" for run in runs}
        for run in runs:
            write_artifacts(uris[run.run_id], run.artifacts)
        all_tags = {run.run_id: {**run.tags, "mlflow.runName": run.name} for run in runs}
        latest = {run.run_id: _latest(run.metrics) for run in runs}
        write = partial(insert_rows, self._connection)
        write(RUNS, [_row(run, experiment, uris[run.run_id]) for run in runs])
        write(TAGS, [row for run_id, tags in all_tags.items() for row in _named(tags, run_id)])
        write(PARAMS, [row for run in runs for row in _named(run.params, run.run_id)])
        write(METRICS, [row for run in runs for row in _metric_rows(run.run_id, run.started, run.metrics)])
        write(
            LATEST_METRICS, [row for run in runs for row in _metric_rows(run.run_id, run.started, latest[run.run_id])]
        )

    def set_tags(self, run_id: str, tags: Mapping[str, str]) -> None:
        """Set tags of a run."""
        self._replace(TAGS, "run_uuid", run_id, tags)

    def remove_tag(self, run_id: str, name: str) -> None:
        """Remove a tag of a run, if it has it."""
        self._connection.execute(delete(TAGS).where(TAGS.c.run_uuid == run_id, TAGS.c.key == name))

    def end(
        self, run_id: str, status: str, ended: int, metrics: Sequence[Metric] = (), artifacts: Mapping[str, bytes] = {}
    ) -> None:
        """End a run.

        Args:
            run_id: of the run.
            status: of the run from now on.
            ended: milliseconds since 1970.
            metrics: that it gets, in place of earlier values; their timestamp is the start of the run.
            artifacts: contents of files by name.
        """
        about = select(RUNS.c.start_time, RUNS.c.artifact_uri).where(RUNS.c.run_uuid == run_id)
        started, uri = self._connection.execute(about).one()
        write_artifacts(uri, artifacts)
        names = {name for name, _, _ in metrics}
        for table, values in ((METRICS, metrics), (LATEST_METRICS, _latest(metrics))):
            self._connection.execute(delete(table).where(table.c.run_uuid == run_id, table.c.key.in_(names)))
            insert_rows(self._connection, table, _metric_rows(run_id, started, values))
        self._connection.execute(update(RUNS).where(RUNS.c.run_uuid == run_id).values(status=status, end_time=ended))

    def _replace(self, table: Table, owner: str, identity: str | int, tags: Mapping[str, str]) -> None:
        if tags:
            self._connection.execute(delete(table).where(table.c[owner] == identity, table.c.key.in_(tags)))
            rows = [{"key": name, "value": value, owner: identity} for name, value in tags.items()]
            insert_rows(self._connection, table, rows)


def _row(run: NewRun, experiment: Experiment, artifacts: str) -> dict[str, Any]:
    return {
        "run_uuid": run.run_id,
        "name": run.name,
        "source_type": "UNKNOWN",
        "source_name": "",
        "entry_point_name": "",
        "user_id": run.tags.get("mlflow.user", "unknown"),
        "status": run.status,
        "start_time": run.started,
        "end_time": run.ended,
        "source_version": "",
        "lifecycle_stage": "active",
        "artifact_uri": artifacts,
        "experiment_id": experiment.id,
    }


def _named(values: Mapping[str, str], run_id: str) -> list[dict[str, str]]:
    return [{"key": name, "value": value, "run_uuid": run_id} for name, value in values.items()]


def _metric_rows(run_id: str, timestamp: int, metrics: Iterable[Metric]) -> list[dict[str, Any]]:
    return [
        {"key": name, "value": value, "timestamp": timestamp, "step": step, "is_nan": False, "run_uuid": run_id}
        for name, value, step in metrics
    ]


def _latest(metrics: Iterable[Metric]) -> list[Metric]:
    """Return the value of the last step of each metric."""
    last: dict[str, Metric] = {}
    for metric in metrics:
        name, _, step = metric
        if name not in last or step >= last[name][2]:
            last[name] = metric
    return list(last.values())
