"""Search of an MLflow tracking server for runs whose answers are read as JSON.

MLflow's client makes a protocol buffer and several objects of every value, which takes as long as the server needs to
answer. The request is its own: address, credentials, retries and errors are as everywhere else. See
docs/decisions/0043-reading-from-a-server.md.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from rl_design_space.tracking.found_run import FoundRun

if TYPE_CHECKING:
    from mlflow import MlflowClient
    from requests import Response

_ENDPOINT = "/api/2.0/mlflow/runs/search"
#: What the id of a run ends with: MLflow makes ids of 32 hexadecimal digits.
_ENDINGS = "0123456789abcdef"
#: Requests at the same time; MLflow's server has four processes by default, which have the next ones while this process
#: decodes answers.
_IN_FLIGHT = 6
#: Runs of the first page, which tells whether there are more; it is read again if there are.
_FIRST_PAGE = 100
#: Runs of each of several pages at the same time. A server process answers them together, so that each takes as long as
#: all of them, and its first byte has to arrive before the request times out, after 10 seconds.
_PER_PAGE = 250
#: A connection stays with one process of the server, and four can have the same; a new one goes to an idle process.
_NEW_CONNECTION = {"Connection": "close"}


def search_runs(client: MlflowClient, experiment: str, filter_: str, per_page: int) -> Iterator[FoundRun]:
    """Yield all active runs of an experiment that match a filter, page by page, as MLflow's client would return them.

    Args:
        client: of the server.
        experiment: id of the experiment.
        filter_: a filter of MLflow's search.
        per_page: number of runs that a request asks for.
    """
    for page, _ in _pages(client, experiment, filter_, per_page):
        yield from page


def search_many(client: MlflowClient, experiment: str, filter_: str) -> list[FoundRun]:
    """Return the runs of `search_runs` in its order, the newest first; several pages are asked for at the same time.

    A page is needed to ask for the next one, so runs are parted by what their ids end with.
    """
    page, is_last = next(_pages(client, experiment, filter_, _FIRST_PAGE))
    if is_last:
        return page

    def part(ending: str) -> list[FoundRun]:
        wanted = f"{filter_} and attributes.run_id LIKE '%{ending}'"
        return [run for page, _ in _pages(client, experiment, wanted, _PER_PAGE, _NEW_CONNECTION) for run in page]

    with ThreadPoolExecutor(_IN_FLIGHT) as pool:
        # A run that is recorded meanwhile moves others to the next page, where they are found again.
        found = {run.run_id: run for runs in pool.map(part, _ENDINGS) for run in runs}
    return sorted(found.values(), key=lambda run: (-run.started, run.run_id))


def _pages(
    client: MlflowClient,
    experiment: str,
    filter_: str,
    per_page: int,
    headers: Mapping[str, str] = MappingProxyType({}),
) -> Iterator[tuple[list[FoundRun], bool]]:
    """Yield pages of runs, each with whether it is the last."""
    from mlflow.utils.rest_utils import http_request

    credentials: Any = client._tracking_client.store.get_host_creds()
    wanted: dict[str, Any] = {"experiment_ids": [experiment], "filter": filter_, "run_view_type": "ACTIVE_ONLY"}
    wanted["max_results"] = per_page
    while True:
        answer = http_request(credentials, _ENDPOINT, "POST", json=wanted, extra_headers=headers)  # type: ignore[no-untyped-call]
        page = _content(answer)
        token = page.get("next_page_token")
        yield list(map(_found, page.get("runs", ()))), not token
        if not token:
            return
        wanted["page_token"] = token


def _content(response: Response) -> dict[str, Any]:
    """Return the content of an answer; MLflow's check would decode it a second time, so errors alone are left to it."""
    from mlflow.utils.rest_utils import verify_rest_response

    if response.status_code == 200:
        with suppress(ValueError):
            content = response.json()
            if isinstance(content, dict):
                return content
    checked: dict[str, Any] = verify_rest_response(response, _ENDPOINT).json()
    return checked


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
