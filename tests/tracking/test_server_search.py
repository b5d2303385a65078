"""Answers of a tracking server, read as MLflow's client would read them."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace
from typing import Any

import pytest

from rl_design_space.tracking.found_run import FoundRun
from rl_design_space.tracking.server_search import search_many, search_runs


def _runs() -> list[Any]:
    from mlflow.entities import Metric, Param, Run, RunData, RunInfo, RunTag

    numbers = {"total_steps": 12.5, "nothing": 0.0, "nan": math.nan, "inf": math.inf, "low": -math.inf, "big": 1.7e308}
    metrics = [Metric(name, value, 3, 0) for name, value in numbers.items()]
    texts = {"world.size": "10", "empty": "", "text": "ünïcode ✓", "long": "x" * 500}
    full = RunData(metrics, [Param(*pair) for pair in texts.items()], [RunTag("fingerprint", "ab"), RunTag("e", "")])
    about = {"status": "FINISHED", "lifecycle_stage": "active", "artifact_uri": "file:///a", "experiment_id": "1"}
    infos = [
        RunInfo(run_id=f"{i:032x}", user_id="u", start_time=1_700_000_000_000 + i, end_time=i + 1, run_name=n, **about)
        for i, n in enumerate(("seed=1", "", "third"))
    ]
    return [Run(info, data) for info, data in zip(infos, (full, RunData(), full), strict=True)]


def test_runs_are_those_of_mlflow_s_client(monkeypatch: pytest.MonkeyPatch):
    from mlflow.entities import Run
    from mlflow.protos.service_pb2 import SearchRuns
    from mlflow.utils import rest_utils
    from mlflow.utils.proto_json_utils import message_to_json, parse_dict

    made = _runs()
    pages, asked = [made[:2], made[2:]], []

    def answer(credentials: str, endpoint: str, method: str, **request: Any) -> SimpleNamespace:
        asked.append((credentials, method, dict(request["json"])))
        token = {} if len(asked) == len(pages) else {"next_page_token": "next"}
        text = message_to_json(SearchRuns.Response(runs=[run.to_proto() for run in pages[len(asked) - 1]], **token))
        return SimpleNamespace(json=lambda: json.loads(text), text=text)

    monkeypatch.setattr(rest_utils, "http_request", answer)
    monkeypatch.setattr(rest_utils, "verify_rest_response", lambda response, endpoint: response)
    store = SimpleNamespace(get_host_creds=lambda: "credentials")
    client: Any = SimpleNamespace(_tracking_client=SimpleNamespace(store=store))
    found = list(search_runs(client, "1", "attributes.status = 'FINISHED'", 2))

    by_client = []
    for page in pages:
        message = SearchRuns.Response()
        parse_dict(json.loads(message_to_json(SearchRuns.Response(runs=[run.to_proto() for run in page]))), message)
        by_client += [Run.from_proto(run) for run in message.runs]
    expected = [
        FoundRun(
            run.info.run_id, run.info.run_name, run.info.start_time, run.info.end_time, run.info.artifact_uri,
            run.data.params, run.data.metrics, run.data.tags,
        )
        for run in by_client
    ]  # fmt: skip
    assert list(map(repr, found)) == list(map(repr, expected))  # NaN differs from itself
    assert [each[2].get("page_token") for each in asked] == [None, "next"]
    assert {(credentials, method) for credentials, method, _ in asked} == {("credentials", "POST")}


@pytest.mark.parametrize("per_page", [1, 5, 30])
def test_many_runs_are_those_of_one_search_after_the_other(monkeypatch: pytest.MonkeyPatch, per_page: int):
    from mlflow.utils import rest_utils

    made = [
        {"info": {"run_id": f"{71 * i % 30:032x}", "start_time": 1_700_000_000_000 - i // 3, "end_time": 0}}
        for i in range(30)
    ]

    def answer(credentials: str, endpoint: str, method: str, **request: Any) -> SimpleNamespace:
        wanted = request["json"]
        ending = wanted["filter"].removeprefix("attributes.status = 'FINISHED'").removeprefix(" and ")
        ending = ending.removeprefix("attributes.run_id LIKE '%").removesuffix("'")
        matching = [run for run in made if run["info"]["run_id"].endswith(ending)]
        ordered = sorted(matching, key=lambda run: (-run["info"]["start_time"], run["info"]["run_id"]))
        begin = int(wanted.get("page_token", 0))
        end = begin + wanted["max_results"]
        token = {"next_page_token": str(end)} if end < len(ordered) else {}
        return SimpleNamespace(json=lambda: {"runs": ordered[begin:end], **token})

    monkeypatch.setattr(rest_utils, "http_request", answer)
    monkeypatch.setattr(rest_utils, "verify_rest_response", lambda response, endpoint: response)
    client: Any = SimpleNamespace(_tracking_client=SimpleNamespace(store=SimpleNamespace(get_host_creds=lambda: "")))
    found = search_many(client, "1", "attributes.status = 'FINISHED'", per_page)
    assert found == list(search_runs(client, "1", "attributes.status = 'FINISHED'", 30))
    assert len(found) == len(made)
