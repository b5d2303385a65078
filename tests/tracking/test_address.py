"""Addresses of tracking stores."""

from __future__ import annotations

from pathlib import Path

import pytest

from rl_design_space.tracking.address import absolute, is_server, sqlite_path


def test_a_relative_path_is_resolved_in_the_working_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    assert sqlite_path("sqlite:///outputs/mlflow.db") == tmp_path / "outputs" / "mlflow.db"
    assert absolute("sqlite:///outputs/mlflow.db") == f"sqlite:///{tmp_path}/outputs/mlflow.db"
    assert sqlite_path("sqlite:////srv/mlflow.db") == Path("/srv/mlflow.db")


@pytest.mark.parametrize(
    ("uri", "server"),
    [("postgresql://host/mlflow", False), ("http://host", True), ("https://host", True), ("databricks", True)],
)
def test_other_stores_have_no_file(uri: str, server: bool):
    assert sqlite_path(uri) is None
    assert absolute(uri) == uri
    assert is_server(uri) is server
