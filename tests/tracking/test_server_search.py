"""Answers of a tracking server, read as MLflow's client would read them."""

from __future__ import annotations

import json
import math
from types import SimpleNamespace
from typing import Any

import pytest

from rl_design_space.tracking import server_search
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


def _client() -> Any:
    store = SimpleNamespace(get_host_creds=lambda: "credentials")
    return SimpleNamespace(_tracking_client=SimpleNamespace(store=store))


def _response(text: str, status: int = 200) -> Any:
    from requests import Response

    response = Response()
    response.status_code, response.encoding, response._content = status, "utf-8", text.encode()
    return response


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
        return _response(text)

    monkeypatch.setattr(rest_utils, "http_request", answer)
    found = list(search_runs(_client(), "1", "attributes.status = 'FINISHED'", 2))

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


@pytest.mark.parametrize(("first", "per_page", "requests"), [(1, 1, 31), (5, 2, 17), (29, 30, 17), (30, 1, 1)])
def test_many_runs_are_those_of_one_search_after_the_other(
    monkeypatch: pytest.MonkeyPatch, first: int, per_page: int, requests: int
):
    from mlflow.utils import rest_utils

    made = [
        {"info": {"run_id": f"{71 * i % 30:032x}", "start_time": 1_700_000_000_000 - i // 3, "end_time": 0}}
        for i in range(30)
    ]
    asked = []

    def answer(credentials: str, endpoint: str, method: str, **request: Any) -> Any:
        asked.append(request["extra_headers"])
        wanted = request["json"]
        ending = wanted["filter"].removeprefix("attributes.status = 'FINISHED'").removeprefix(" and ")
        ending = ending.removeprefix("attributes.run_id LIKE '%").removesuffix("'")
        matching = [run for run in made if run["info"]["run_id"].endswith(ending)]
        ordered = sorted(matching, key=lambda run: (-run["info"]["start_time"], run["info"]["run_id"]))
        begin = int(wanted.get("page_token", 0))
        end = begin + wanted["max_results"]
        token = {"next_page_token": str(end)} if end < len(ordered) else {}
        return _response(json.dumps({"runs": ordered[begin:end], **token}))

    monkeypatch.setattr(rest_utils, "http_request", answer)
    monkeypatch.setattr(server_search, "_FIRST_PAGE", first)
    monkeypatch.setattr(server_search, "_PER_PAGE", per_page)
    found = search_many(_client(), "1", "attributes.status = 'FINISHED'")
    # A connection each, so that a server of several processes divides the requests among them.
    assert asked == [{}] + [{"Connection": "close"}] * (requests - 1)
    assert found == list(search_runs(_client(), "1", "attributes.status = 'FINISHED'", 30))
    assert len(found) == len(made)


def test_a_run_that_is_recorded_meanwhile_doubles_no_other(monkeypatch: pytest.MonkeyPatch):
    from mlflow.utils import rest_utils

    ids = [f"{i:031x}0" for i in range(3)]

    def answer(*_: Any, **request: Any) -> Any:
        begin = int(request["json"].get("page_token", 0))
        there = ids if begin == 0 else ["f" * 31 + "0", *ids]
        matching = [each for each in there if "%" not in request["json"]["filter"] or "%0" in request["json"]["filter"]]
        page = [{"info": {"run_id": each}} for each in matching[begin : begin + 2]]
        token = {"next_page_token": str(begin + 2)} if begin + 2 < len(matching) else {}
        return _response(json.dumps({"runs": page, **token}))

    monkeypatch.setattr(rest_utils, "http_request", answer)
    monkeypatch.setattr(server_search, "_FIRST_PAGE", 2)
    monkeypatch.setattr(server_search, "_PER_PAGE", 2)
    assert [run.run_id for run in search_many(_client(), "1", "attributes.status = 'FINISHED'")] == ids


@pytest.mark.parametrize(
    ("text", "status", "message"),
    [
        ('{"error_code": "PERMISSION_DENIED", "message": "not yours"}', 403, "PERMISSION_DENIED: not yours"),
        ("<html>a proxy</html>", 200, "not in a valid JSON format"),
        ("[]", 200, "not in a valid JSON format"),
    ],
)
def test_errors_are_those_of_mlflow_s_client(monkeypatch: pytest.MonkeyPatch, text: str, status: int, message: str):
    from mlflow.exceptions import MlflowException
    from mlflow.utils import rest_utils

    monkeypatch.setattr(rest_utils, "http_request", lambda *_, **__: _response(text, status))
    with pytest.raises(MlflowException, match=message):
        search_many(_client(), "1", "")


def test_an_empty_answer_is_no_run(monkeypatch: pytest.MonkeyPatch):
    from mlflow.utils import rest_utils

    monkeypatch.setattr(rest_utils, "http_request", lambda *_, **__: _response(""))
    assert search_many(_client(), "1", "") == []
