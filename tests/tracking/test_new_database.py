"""Creating databases: an empty one is kept and copied."""

from __future__ import annotations

import sqlite3
import time
from contextlib import closing
from pathlib import Path

import pytest

from rl_design_space.tracking import new_database
from rl_design_space.tracking.new_database import create_database
from tests.tracking.stores import copy_database


@pytest.fixture
def created(monkeypatch: pytest.MonkeyPatch, empty_database: Path) -> list[str]:
    """URIs of the databases that MLflow has created; a copy takes its part, because it takes seconds."""
    uris: list[str] = []

    def create(uri: str) -> None:
        uris.append(uri)
        path = Path(uri.removeprefix("sqlite:///"))
        copy_database(empty_database, path)
        with closing(sqlite3.connect(path)) as database:
            database.execute("PRAGMA journal_mode = DELETE")  # as MLflow creates it

    monkeypatch.setattr(new_database, "checked_client", create)
    return uris


def default_experiment(database: Path) -> tuple[str, int]:
    with closing(sqlite3.connect(database)) as connection:
        return connection.execute("select artifact_location, creation_time from experiments").fetchone()


def test_the_first_database_is_kept_and_copied(created: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    before = int(time.time() * 1000)
    for name in ("one.db", "other.db"):
        create_database(tmp_path / name, tmp_path / "kept")
    assert created == [f"sqlite:///{tmp_path}/.one.db.new"]
    (kept,) = (tmp_path / "kept").iterdir()
    assert kept.name.startswith("mlflow-")
    # As if it had been created in this place at this moment.
    monkeypatch.chdir(tmp_path)
    create_database(tmp_path / "third.db", tmp_path / "kept")
    location, moment = default_experiment(tmp_path / "third.db")
    assert location == f"{tmp_path}/mlruns/0"
    assert moment >= before
    assert {path.name for path in tmp_path.iterdir()} == {"kept", "one.db", "other.db", "third.db"}


@pytest.mark.parametrize("damage", [b"", b"SQLite format 3\0 and then nothing", None])
def test_a_damaged_database_is_created_again(created: list[str], tmp_path: Path, damage: bytes | None):
    create_database(tmp_path / "one.db", tmp_path / "kept")
    (kept,) = (tmp_path / "kept").iterdir()
    whole = kept.read_bytes()
    kept.write_bytes(whole[: len(whole) // 2] if damage is None else damage)
    create_database(tmp_path / "other.db", tmp_path / "kept")
    assert len(created) == 2
    assert default_experiment(tmp_path / "other.db")
    create_database(tmp_path / "third.db", tmp_path / "kept")
    assert len(created) == 2


def test_a_folder_that_cannot_be_written_to_keeps_nothing(created: list[str], tmp_path: Path):
    (tmp_path / "kept").write_text("a file", encoding="utf-8")
    for name in ("one.db", "other.db"):
        create_database(tmp_path / name, tmp_path / "kept")
        assert default_experiment(tmp_path / name)
    assert len(created) == 2
