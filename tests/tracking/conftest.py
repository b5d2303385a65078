"""Creating a database takes MLflow seconds, so it is done once and copied."""

from __future__ import annotations

from pathlib import Path

import pytest

from rl_design_space.tracking.store import connect
from tests.tracking.stores import copy_database, import_mlflow


@pytest.fixture(scope="session")
def empty_database(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A database as MLflow creates it, with no experiment of ours."""
    import_mlflow()
    database = tmp_path_factory.mktemp("empty") / "mlflow.db"
    connect(f"sqlite:///{database}")
    return database


@pytest.fixture
def database(empty_database: Path, tmp_path: Path) -> Path:
    """A new database of a test's own."""
    copy_database(empty_database, tmp_path / "mlflow.db")
    return tmp_path / "mlflow.db"


@pytest.fixture(scope="module")
def shared_database(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A database that the tests of a module share and leave as it is."""
    database = tmp_path_factory.mktemp("shared") / "mlflow.db"
    copy_database(empty_database, database)
    return database
