"""Rows that drivers of databases get as they are."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from sqlalchemy import Column, Engine, Integer, MetaData, String, Table, create_engine, select, text
from sqlalchemy.exc import IntegrityError, OperationalError

from rl_design_space.tracking.bulk_insert import insert_rows
from rl_design_space.tracking.store_errors import is_transient
from tests.servers import Postgres, needs_postgres

TABLE = Table("odd name", MetaData(), Column("key", String, primary_key=True), Column("order", Integer))
#: In another order than the columns of the table.
ROWS = [
    {"order": None, "key": "tab\t, line\n, return\r and \\N"},
    {"order": 2, "key": "% %s ? :name 'quoted' \"twice\" ∞"},
    {"order": -1, "key": ""},
]


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=needs_postgres)])
def engine(request: pytest.FixtureRequest) -> Iterator[Engine]:
    sqlite = request.param == "sqlite"
    postgres: Postgres | None = None if sqlite else request.getfixturevalue("postgres")
    engine = create_engine(postgres.create() if postgres else "sqlite://")
    TABLE.create(engine)
    yield engine
    engine.dispose()


def test_values_are_stored_as_they_are(engine: Engine):
    with engine.begin() as connection:
        insert_rows(connection, TABLE, ROWS)
        insert_rows(connection, TABLE, [])
    with engine.connect() as connection:
        found = {row.key: row.order for row in connection.execute(select(TABLE))}
    assert found == {row["key"]: row["order"] for row in ROWS}


def test_a_row_that_is_there_is_refused_and_none_is_stored(engine: Engine):
    with pytest.raises(IntegrityError), engine.begin() as connection:
        insert_rows(connection, TABLE, [*ROWS, ROWS[0]])
    with engine.connect() as connection:
        assert not connection.execute(select(TABLE)).all()


@needs_postgres
def test_a_connection_that_is_lost_is_transient(postgres: Postgres):
    engine, other = (create_engine(uri) for uri in [postgres.create()] * 2)
    TABLE.create(engine)

    def insert(*, lost: bool) -> None:
        with engine.begin() as connection:
            if lost:
                with other.begin() as killer:
                    ours = connection.scalar(text("select pg_backend_pid()"))
                    killer.execute(text(f"select pg_terminate_backend({ours})"))
            insert_rows(connection, TABLE, ROWS)

    with pytest.raises(OperationalError) as raised:
        insert(lost=True)
    assert is_transient(raised.value)
    insert(lost=False)
    engine.dispose()
    other.dispose()
