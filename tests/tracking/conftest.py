"""Databases, trackers and clients."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.tracking.stores import copy_database, tracker_at


@pytest.fixture
def database(empty_database: Path, tmp_path: Path) -> Path:
    """An empty database."""
    copy_database(empty_database, tmp_path / "mlflow.db")
    return tmp_path / "mlflow.db"


@pytest.fixture(scope="module")
def shared_database(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A database that the tests of a module share."""
    database = tmp_path_factory.mktemp("shared") / "mlflow.db"
    copy_database(empty_database, database)
    return database


@pytest.fixture
def tracker(database: Path):
    return tracker_at(database)


@pytest.fixture
def client(database: Path):
    from mlflow import MlflowClient

    return MlflowClient(f"sqlite:///{database}")
