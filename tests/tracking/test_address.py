"""Addresses of tracking stores."""

from __future__ import annotations

from pathlib import Path

import pytest
import sqlalchemy
from hypothesis import given, settings
from hypothesis import strategies as st

import rl_design_space as rds
from rl_design_space.config.build import construct
from rl_design_space.errors import ConfigError
from rl_design_space.tracking import MlflowTracking
from rl_design_space.tracking.address import (
    absolute,
    is_server,
    mlflow_uri,
    sqlite_path,
)
from tests.tracking.stores import copy_database, learned, options, record, tracker_at


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
    assert absolute(uri) == mlflow_uri(uri) == uri
    assert is_server(uri) is server


NAMES = st.text(min_size=1, max_size=12).map(lambda name: name.replace("/", "?").replace("\0", "%"))


@given(st.lists(NAMES, min_size=1, max_size=3).map(lambda names: "/" + "/".join(names)))
@settings(max_examples=100)
def test_every_path_is_found_by_sqlalchemy_where_it_is(path: str):
    uri = absolute(f"sqlite:///{path}")
    assert sqlite_path(uri) == Path(path)
    assert sqlalchemy.make_url(mlflow_uri(uri)).database == str(Path(path))
    if not set("?%") & set(path):
        assert mlflow_uri(uri) == uri == f"sqlite:///{Path(path)}"  # the identity of existing spools
    else:  # MLflow creates the parent of the path that it reads
        assert Path(mlflow_uri(uri).removeprefix("sqlite:///")).parent in (Path(path), *Path(path).parents)


@pytest.mark.parametrize("writer", ["direct", "client"])
def test_a_point_is_recorded_and_read_in_a_folder_of_any_name(
    writer: str, empty_database: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    if writer == "client":
        monkeypatch.setattr("rl_design_space.tracking.database_engine.REVISIONS", frozenset())
    database = tmp_path / "it's a?b%20c #d" / "mlflow.db"
    copy_database(empty_database, database)
    planned, curves = learned()
    stored = record(tracker_at(database), planned, curves)
    reader = options(database).reader()
    assert reader.finished([planned.fingerprint]) == {planned.fingerprint: stored}
    assert (reader.periods(stored)["steps"] == curves.steps).all()
    assert [path.name for path in tmp_path.iterdir()] == [database.parent.name]


@pytest.mark.parametrize(
    ("settings_", "message"),
    [
        ({"uri": "http://secret@host"}, "uri=http://…@host: should not hold a password or token"),
        ({"uri": "postgresql://me@host/db?sslpassword=secret"}, "should not hold a password or token"),
        ({"uri": "http:/host"}, "should name a host"),
        ({"uri": "postgresql://me@host/my db"}, "should not hold spaces"),
        ({"uri": "sqlite:///a\nb"}, "control characters"),
    ],
)
def test_an_address_that_leads_elsewhere_or_holds_a_secret_is_refused(settings_: dict[str, str], message: str):
    with pytest.raises(ConfigError) as caught:
        construct(MlflowTracking, {"uri": "sqlite:///mlflow.db", **settings_}, "tracking")
    assert message in str(caught.value)
    assert "secret" not in str(caught.value)
    with pytest.raises(ConfigError) as caught:
        rds.load_runs(uri=settings_["uri"])
    assert message in str(caught.value)
