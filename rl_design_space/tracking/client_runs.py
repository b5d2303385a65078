"""Runs of a tracking store, written step by step with MLflow's client."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, TypeVar

from rl_design_space.tracking.store_errors import StoreUnavailableError

if TYPE_CHECKING:
    from mlflow import MlflowClient
    from mlflow.entities import FileInfo, Run, RunInfo

#: Most params of a request, and most metrics beside them and few tags: servers refuse more than 1000 values.
_PARAMS, _METRICS = 100, 890

#: Name, value and step of a metric; name and value of a param or a tag.
Metric = tuple[str, float, int]
Param = tuple[str, str]
Value = TypeVar("Value")


class ClientRuns:
    """The runs of any store.

    Attributes:
        in_flight: number of runs that are written at a time.

    Args:
        client: of the store.
        uri: of the store.
    """

    in_flight = 1

    def __init__(self, client: MlflowClient, uri: str) -> None:
        self._client = client
        self._uri = uri

    def create(self, experiment: str, name: str, started: int, tags: Mapping[str, str]) -> RunInfo:
        """Create a RUNNING run.

        Args:
            experiment: id of its experiment.
            name: of the run.
            started: milliseconds since 1970.
            tags: values by name.
        """
        run = self._client.create_run(experiment, start_time=started, run_name=name, tags=dict(tags))
        return run.info

    def find(self, experiment: str, tag: str, value: str) -> Sequence[Run]:
        """Return the runs of an experiment that have a tag with a value; only their tags need be complete."""
        return self._client.search_runs([experiment], f"tags.`{tag}` = '{value}'")

    def tag(self, run_id: str, tags: Mapping[str, str]) -> None:
        """Set tags of a run."""
        from mlflow.entities import RunTag

        if tags:
            self._client.log_batch(run_id, tags=[RunTag(name, value) for name, value in tags.items()])

    def log(
        self,
        run_id: str,
        timestamp: int,
        metrics: Sequence[Metric],
        params: Mapping[str, str],
        tags: Mapping[str, str] = {},
    ) -> None:
        """Log params, metrics and tags; repeating it changes nothing, because all timestamps are equal."""
        parts = (_parts(metrics, _METRICS), _parts(list(params.items()), _PARAMS), [list(tags.items())])
        for some_metrics, some_params, some_tags in zip_longest(*parts, fillvalue=()):
            self._log_batch(run_id, timestamp, some_metrics, some_params, some_tags)

    def upload(self, run: RunInfo, artifacts: Mapping[str, bytes]) -> None:
        """Upload files.

        Raises:
            StoreUnavailableError: the store has answered that it has them, and has not.
        """
        if not artifacts:
            return
        with TemporaryDirectory() as folder:
            for name, content in artifacts.items():
                (Path(folder) / name).write_bytes(content)
            found = self._upload_folder(run, folder)
        stored = {file.path: file.file_size for file in found}
        if lacking := [name for name, content in artifacts.items() if stored.get(name) != len(content)]:
            raise StoreUnavailableError(f"{self._uri}: was sent {', '.join(lacking)}, and does not have it")

    def end(self, run_id: str, status: str, ended: int | None = None) -> None:
        """End a run, now or at a time in milliseconds since 1970."""
        self._client.set_terminated(run_id, status, ended)

    def _log_batch(
        self,
        run_id: str,
        timestamp: int,
        metrics: Sequence[Metric],
        params: Sequence[Param],
        tags: Sequence[Param],
    ) -> None:
        """Log values in a single request."""
        from mlflow import entities

        values = [entities.Metric(name, value, timestamp, step) for name, value, step in metrics]
        self._client.log_batch(
            run_id,
            metrics=values,
            params=[entities.Param(name, value) for name, value in params],
            tags=[entities.RunTag(name, value) for name, value in tags],
        )

    def _upload_folder(self, run: RunInfo, folder: str) -> Iterable[FileInfo]:
        """Upload the files of a folder; return those that the run has now."""
        self._client.log_artifacts(run.run_id, folder)
        return self._client.list_artifacts(run.run_id)


def _parts(values: Sequence[Value], size: int) -> list[Sequence[Value]]:
    return [values[first : first + size] for first in range(0, len(values), size)]
