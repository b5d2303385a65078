"""Runs of a tracking server, written with as few and as cheap requests as its API allows."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rl_design_space.tracking.client_runs import ClientRuns, Metric, Param

if TYPE_CHECKING:
    from mlflow.entities import FileInfo, Run, RunInfo

_API = "/api/2.0/mlflow/runs"
#: Tag with the user who records.
_USER = "mlflow.user"


class ServerRuns(ClientRuns):
    """The runs of a tracking server.

    MLflow's client converts every value of a curve four times before it is sent, and asks twice for a run that has just
    been created. What remains are seven requests for a point, sent with MLflow's own function for requests, which knows
    about logins, certificates and retries.
    """

    in_flight = 4

    def create(self, experiment: str, name: str, started: int, tags: Mapping[str, str]) -> RunInfo:
        """Create a RUNNING run, see `ClientRuns.create`."""
        body = {
            "experiment_id": experiment,
            "user_id": tags.get(_USER, "unknown"),
            "run_name": name,
            "start_time": started,
            "tags": [{"key": key, "value": value} for key, value in tags.items()],
        }
        return _run(self._post("create", body)["run"]).info

    def find(self, experiment: str, tag: str, value: str) -> Sequence[Run]:
        """Return the runs of an experiment that have a tag with a value, without metrics and params."""
        wanted = {"experiment_ids": [experiment], "filter": f"tags.`{tag}` = '{value}'", "max_results": 1000}
        return [_run(found) for found in self._post("search", wanted).get("runs", [])]

    def end(self, run_id: str, status: str, ended: int | None = None) -> None:
        """End a run, now or at a time in milliseconds since 1970."""
        self._post("update", {"run_id": run_id, "status": status, "end_time": ended or int(time.time() * 1000)})

    def _log_batch(
        self,
        run_id: str,
        timestamp: int,
        metrics: Sequence[Metric],
        params: Sequence[Param],
        tags: Sequence[Param],
    ) -> None:
        body = {
            "run_id": run_id,
            "metrics": [
                {"key": name, "value": value, "timestamp": timestamp, "step": step} for name, value, step in metrics
            ],
            "params": [{"key": name, "value": value} for name, value in params],
            "tags": [{"key": name, "value": value} for name, value in tags],
        }
        self._post("log-batch", body)

    def _upload_folder(self, run: RunInfo, folder: str) -> Iterable[FileInfo]:
        from mlflow.store.artifact.artifact_repository_registry import get_artifact_repository

        files = get_artifact_repository(run.artifact_uri, tracking_uri=self._uri)
        files.log_artifacts(folder)  # type: ignore[no-untyped-call]
        return files.list_artifacts()

    def _post(self, what: str, body: Mapping[str, Any]) -> Any:
        from mlflow.utils.credentials import get_default_host_creds
        from mlflow.utils.rest_utils import http_request, verify_rest_response

        endpoint = f"{_API}/{what}"
        credentials = get_default_host_creds(self._uri)  # type: ignore[no-untyped-call]
        answer = http_request(credentials, endpoint, "POST", json=body)  # type: ignore[no-untyped-call]
        return verify_rest_response(answer, endpoint).json()


def _run(found: Mapping[str, Any]) -> Run:
    from mlflow.entities import Run, RunData, RunInfo, RunTag

    info, tags = found["info"], found.get("data", {}).get("tags", [])
    about = RunInfo(
        info["run_id"],
        info["experiment_id"],
        info.get("user_id", ""),
        info["status"],
        int(info["start_time"]),
        int(info["end_time"]) if "end_time" in info else None,
        info["lifecycle_stage"],
        info["artifact_uri"],
        info.get("run_name"),
    )
    return Run(about, RunData(tags=[RunTag(tag["key"], tag["value"]) for tag in tags]))
