"""A database of another MLflow is refused when it is opened for recording; it can still be read."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.tracking import MlflowTracking
from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.queries import queries_of
from rl_design_space.tracking.schema import check_schema
from tests.tracking.stores import copy_database


@pytest.mark.parametrize(
    ("version", "message"),
    [
        ("c48cb773bb87", r"older MLflow \(c48cb773bb87\); back it up, then run `mlflow db upgrade sqlite:///.*`"),
        ("feedfacecafe", r"newer MLflow \(feedfacecafe\); install that version of MLflow, or name another store"),
    ],
)
def test_the_tables_of_another_mlflow_are_refused_before_anything_is_run(
    version: str, message: str, tmp_path: Path, empty_database: Path
):
    database = tmp_path / "mlflow.db"
    copy_database(empty_database, database)
    tracking = MlflowTracking(uri=f"sqlite:///{database}", spool=str(tmp_path / "spool"))
    check_schema(tracking.address)
    with closing(sqlite3.connect(database)) as connection, connection:
        connection.execute("update alembic_version set version_num = ?", [version])
    with pytest.raises(ConfigError, match=message):
        tracking.open()
    assert queries_of(tracking.address).finished(["x"]) == {}


@pytest.mark.parametrize(
    "uri", ["sqlite:///{}/none.db", "sqlite:///{}/no_database", "postgresql+psycopg://127.0.0.1:9/x"]
)
def test_a_store_that_cannot_be_read_is_left_to_others(uri: str, tmp_path: Path):
    (tmp_path / "no_database").write_text("none", encoding="utf-8")
    check_schema(StoreAddress(uri.format(tmp_path), "design points", "sweeps"))
