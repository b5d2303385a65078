"""Search of an MLflow tracking server for runs whose answers are read as JSON.

MLflow's client makes a protocol buffer and several objects of every value, which takes as long as the server needs to
answer. The request is its own: address, credentials, retries and errors are as everywhere else.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from rl_design_space.tracking.found_run import FoundRun

if TYPE_CHECKING:
    from mlflow import MlflowClient

_ENDPOINT = "/api/2.0/mlflow/runs/search"


def search_runs(client: MlflowClient, experiment: str, filter_: str, per_page: int) -> Iterator[FoundRun]:
    """Yield all active runs of an experiment that match a filter, page by page, as MLflow's client would return them.

    Args:
        client: of the server.
        experiment: id of the experiment.
        filter_: a filter of MLflow's search.
        per_page: number of runs that a request asks for.
    """
    from mlflow.utils.rest_utils import http_request, verify_rest_response

    credentials: Any = client._tracking_client.store.get_host_creds()
    wanted: dict[str, Any] = {"experiment_ids": [experiment], "filter": filter_, "run_view_type": "ACTIVE_ONLY"}
    wanted["max_results"] = per_page
    while True:
        response = http_request(credentials, _ENDPOINT, "POST", json=wanted)  # type: ignore[no-untyped-call]
        page: dict[str, Any] = verify_rest_response(response, _ENDPOINT).json()
        yield from map(_found, page.get("runs", ()))
        if not (token := page.get("next_page_token")):
            return
        wanted["page_token"] = token


def _found(run: dict[str, Any]) -> FoundRun:
    info, data = run["info"], run.get("data", {})
    params, metrics, tags = (data.get(kind, ()) for kind in ("params", "metrics", "tags"))
    return FoundRun(
        info["run_id"],
        info.get("run_name", ""),
        int(info.get("start_time", 0)),
        int(info.get("end_time", 0)),
        info.get("artifact_uri", ""),
        {param["key"]: param.get("value", "") for param in params},
        {metric["key"]: float(metric.get("value", 0)) for metric in metrics},  # NaN and infinity are texts in JSON
        {tag["key"]: tag.get("value", "") for tag in tags},
    )
