"""Writing into a database directly: its rows are those that MLflow's client would have written."""

from __future__ import annotations

import json
import shutil
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import asdict, replace
from pathlib import Path
from time import sleep

import pytest
import sqlalchemy

from rl_design_space.learning.measures import CURVES_ON_DEMAND
from rl_design_space.plan.plan import Plan
from rl_design_space.tracking import database_tables
from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.client_writer import ClientWriter
from rl_design_space.tracking.database import DatabaseQueries
from rl_design_space.tracking.database_runs import DatabaseRuns
from rl_design_space.tracking.database_writer import DatabaseWriter
from rl_design_space.tracking.delivery import deliver_all
from rl_design_space.tracking.locks import locks_at, locks_path
from rl_design_space.tracking.spool import Spool, is_point
from rl_design_space.tracking.store_writer import open_writer
from rl_design_space.tracking.tracker import SweepEnding
from tests.servers import Postgres, needs_postgres
from tests.tracking.stores import COMMAND, copy_database, learned, undelivered_tracker_at

POINTS = [
    learned("task.trials=1600"),  # more values than a batch of the client holds
    learned("seed=1", "representation=direction", "exploration=linear"),
    learned("world.size=[3,4]", "task.periods=1"),
]
#: Columns of ids, of folders, and of times at which something is written.
IGNORED = {"run_uuid", "artifact_uri", "artifact_location", "creation_time", "last_update_time"}


@pytest.fixture(scope="module")
def recorded(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> Spool:
    """A spool with pending records of all kinds: a sweep, its points, a point that joins a study."""
    database = tmp_path_factory.mktemp("recorded") / "mlflow.db"
    copy_database(empty_database, database)
    tracker = undelivered_tracker_at(database)
    tracker._recorded |= {"curves": CURVES_ON_DEMAND, "every": 3}
    sweep = tracker.open_sweep(Plan(tuple(planned for planned, _ in POINTS), studies=("mine", "yours")), COMMAND)
    for planned, curves in POINTS:
        tracker.record(replace(planned, studies=("a",)), curves)
    (first, _), *_ = POINTS
    stored = tracker.finished([first.fingerprint])
    tracker.add_studies(stored, {first.fingerprint: ("b",)})
    sweep.close(SweepEnding("FAILED", "1 failed", {"done": 3, "failed": 1}, {"the command": "an error"}, stored))
    return tracker._spool


def copy_of(recorded: Spool, uri: str, folder: Path) -> Spool:
    """Return a spool with the same records for another store."""
    copied = Spool.of(folder / "spool", replace(recorded.address, uri=uri))
    shutil.copytree(recorded.folder, copied.folder, dirs_exist_ok=True)
    address = asdict(replace(recorded.address, uri=uri))
    (copied.folder / "store.json").write_text(json.dumps(address), encoding="utf-8")
    return copied


def delivered(spool: Spool, writer: type) -> dict[str, list[str]]:
    """Deliver all records; return the rows of all tables."""
    with closing(open_writer(spool, locks_at(locks_path(spool.address.uri)))) as opened:
        assert isinstance(opened, writer)
    assert deliver_all(spool, 1) == ""
    assert spool.pending() == spool.quarantined() == []
    return rows(spool.address.uri)


def rows(uri: str) -> dict[str, list[str]]:
    """Return the rows of all tables but for ids and times; a run is known by its name."""
    tables, engine = sqlalchemy.MetaData(), sqlalchemy.create_engine(uri)
    tables.reflect(engine)
    with engine.connect() as connection:
        names = dict(connection.execute(sqlalchemy.text("select run_uuid, name from runs")).all())
        found = {}
        for table in tables.sorted_tables:
            held = connection.execute(table.select()).mappings().all()
            found[table.name] = sorted(repr(comparable(dict(row), names)) for row in held)
    engine.dispose()
    return found


def comparable(row: dict, names: dict[str, str]) -> dict:
    kept = {name: value for name, value in row.items() if name not in IGNORED}
    if "run_uuid" in row:
        kept["run"] = names[row["run_uuid"]]
    if kept.get("key") == "mlflow.note.content":  # pictures are addressed by the id of the run
        kept["value"] = kept["value"].replace(row["run_uuid"], "RUN")
    return kept


def files(folder: Path) -> dict[str, list[bytes]]:
    """Return the contents of all artifacts by their names."""
    found: dict[str, list[bytes]] = {}
    for path in folder.glob("artifacts/*/*/artifacts/*"):
        found.setdefault(path.name, []).append(path.read_bytes())
    return {name: sorted(contents) for name, contents in found.items()}


@pytest.fixture(scope="module")
def by_client(recorded: Spool, empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple:
    """Rows and files that MLflow's client writes into a SQLite database."""
    folder = tmp_path_factory.mktemp("client")
    copy_database(empty_database, folder / "mlflow.db")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(database_tables, "REVISIONS", frozenset())
        found = delivered(copy_of(recorded, f"sqlite:///{folder}/mlflow.db", folder), ClientWriter)
    return found, files(folder)


def check(written: tuple, expected: tuple) -> None:
    """Check that the same is written into all tables and files."""
    (tables, kept), (expected_tables, expected_files) = written, expected
    assert len(expected_tables["runs"]) == 4
    assert len(expected_tables["metrics"]) > 3000
    assert len(expected_tables["experiment_tags"]) > 4
    assert set(expected_files) == {
        *("config.yaml", "periods.npz", "curve.svg", "plan.csv", "leaderboard.csv", "failures.csv")
    }
    pictures = [row for row in expected_tables["tags"] if "](get-artifact?path=curve.svg&run_uuid=RUN)" in row]
    assert len(pictures) == 3
    for table, values in expected_tables.items():
        assert tables[table] == values, table
    assert kept == expected_files


def test_sqlite_holds_what_the_client_writes(recorded: Spool, database: Path, by_client: tuple):
    found = delivered(copy_of(recorded, f"sqlite:///{database}", database.parent), DatabaseWriter)
    check((found, files(database.parent)), by_client)


@pytest.fixture(scope="module")
def in_postgres(recorded: Spool, postgres: Postgres, tmp_path_factory: pytest.TempPathFactory) -> tuple:
    """URI of a database in PostgreSQL, and the rows and files that were written into it."""
    folder, uri = tmp_path_factory.mktemp("postgres"), postgres.create()
    found = delivered(copy_of(recorded, uri, folder), DatabaseWriter)
    return uri, found, files(folder)


@needs_postgres
def test_postgresql_holds_what_the_client_writes(in_postgres: tuple, by_client: tuple):
    _, found, written = in_postgres
    # Statistics that SQLite's query planner keeps.
    expected, kept = by_client
    check((found, written), ({name: values for name, values in expected.items() if name in found}, kept))


@needs_postgres
def test_two_machines_record_a_point_once_in_postgresql(
    recorded: Spool, in_postgres: tuple, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Without a lock, both find nothing, and both write a run before either is committed."""
    uri, *_ = in_postgres
    find = DatabaseRuns.find

    def slow(*arguments: object, **others: object) -> dict[str, str]:
        found = find(*arguments, **others)
        sleep(0.5)
        return found

    monkeypatch.setattr(DatabaseRuns, "find", slow)
    point = recorded.read(next(filter(is_point, recorded.pending())))
    spools = [Spool.of(tmp_path / name, StoreAddress(uri, "twice", "sweeps")) for name in ("one", "other")]
    for started, spool in enumerate(spools):
        spool.write(replace(point, content={**point.content, "started": started, "tags": {f"study.{started}": "true"}}))
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(lambda spool: deliver_all(spool, 20), spools)) == ["", ""]
    queries = DatabaseQueries(spools[0].address)
    (run,) = queries.runs()
    queries._connections.dispose()
    assert {"study.0", "study.1"} <= run.tags.keys()
