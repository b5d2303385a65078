"""Files of runs on a server: one request each, and MLflow's client for all that is out of the ordinary."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import requests

from rl_design_space.tracking import MlflowTracking
from rl_design_space.tracking.delivery import deliver_all
from rl_design_space.tracking.download import download
from rl_design_space.tracking.run_files import DamagedFileError
from rl_design_space.tracking.tracker import StoredRun
from tests.servers import MlflowServer, needs_postgres
from tests.tracking.stores import learned, undelivered_tracker_at

HANDED_OUT = "mlflow-artifacts:/1/abc/artifacts"


@pytest.mark.parametrize(
    ("server", "artifacts", "status", "url"),
    [
        ("http://host:5000", HANDED_OUT, 200, "http://host:5000"),
        ("https://host/behind/", HANDED_OUT, 200, "https://host/behind"),
        ("http://host:5000", HANDED_OUT, 404, None),
        ("http://host:5000", "mlflow-artifacts://other:5000/1/abc/artifacts", 200, None),
        ("http://host:5000", "s3://bucket/1/abc/artifacts", 200, None),
        ("http://host:5000", "", 200, None),
        ("postgresql://host/mlflow", HANDED_OUT, 200, None),
    ],
)
def test_what_the_server_does_not_hand_out_is_left_to_the_client(
    server: str, artifacts: str, status: int, url: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    from mlflow.utils import rest_utils

    asked = []

    def answer(credentials: Any, endpoint: str, method: str) -> SimpleNamespace:
        asked.append((method, credentials.host + endpoint))
        return SimpleNamespace(status_code=status, content=b"content")

    monkeypatch.setattr(rest_utils, "http_request", answer)
    by_client = SimpleNamespace(tracking_uri=server, download_artifacts=lambda *given: " ".join(given))
    path = download(by_client, StoredRun("abc", artifacts=artifacts), "periods.npz", tmp_path)
    if url is None:
        assert str(path) == f"abc periods.npz {tmp_path}"
    else:
        assert path.read_bytes() == b"content"
        assert asked == [("GET", f"{url}/api/2.0/mlflow-artifacts/artifacts/1/abc/artifacts/periods.npz")]


@needs_postgres
def test_a_file_takes_one_request(mlflow_server: MlflowServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    planned, curves = learned()
    names = {"uri": mlflow_server.uri, "experiment": "fetched", "sweeps": "fetched s", "spool": str(tmp_path / "spool")}
    tracker = undelivered_tracker_at(tmp_path / "none", **names)
    tracker.record(planned, curves)
    assert deliver_all(tracker._spool, 5) == ""
    reader = MlflowTracking(**names).reader()
    run = reader.finished([planned.fingerprint])[planned.fingerprint]
    reader.config(run)  # connects

    asked, request = [], requests.Session.request

    def counted(session: requests.Session, method: str, url: str, **more: Any) -> requests.Response:
        asked.append(url)
        return request(session, method, url, **more)

    monkeypatch.setattr(requests.Session, "request", counted)
    np.testing.assert_array_equal(reader.periods(run)["steps"], curves.steps)
    assert len(asked) == 1

    (file,) = mlflow_server.log.parent.rglob(f"{run.run_id}/artifacts/periods.npz")
    file.unlink()
    with pytest.raises(DamagedFileError, match=rf"run {run.run_id}: periods\.npz is damaged \(Failed to download"):
        reader.periods(run)
