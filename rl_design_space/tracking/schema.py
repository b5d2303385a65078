"""The version of the tables of an MLflow database, compared with that of the installed MLflow before points are run."""

from __future__ import annotations

import re
import sqlite3
from contextlib import closing
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.address import StoreAddress, sqlite_path
from rl_design_space.tracking.read_only import opened, unwritable

_QUERY = "select version_num from alembic_version"
#: Folder of MLflow with one file for each version of the tables, and what such a file says.
_VERSIONS = Path("store", "db_migrations", "versions")
_REVISION = re.compile(r"^(down_)?revision = [\"'](\w+)[\"']", re.MULTILINE)
#: Seconds to wait for a database server.
_PATIENCE = 5


def check_schema(address: StoreAddress) -> None:
    """Refuse a database whose tables the installed MLflow would refuse, after everything was learned.

    A database that cannot be read is left to others, which report it.

    Raises:
        ConfigError: its tables are those of an older or a newer MLflow.
    """
    found, (known, newest) = _version(address), _versions()
    if found is None or not newest or found == newest:
        return
    if found in known:
        advice = f"back it up, then run `mlflow db upgrade {address.uri}`"
        raise ConfigError.at("tracking.uri", address.uri, f"has the tables of an older MLflow ({found}); {advice}")
    advice = "install that version of MLflow, or name another store"
    raise ConfigError.at("tracking.uri", address.uri, f"has the tables of a newer MLflow ({found}); {advice}")


def _version(address: StoreAddress) -> str | None:
    """Return the version of the tables of a database; None if it is not known."""
    try:
        if path := sqlite_path(address.uri):
            if not path.exists():
                return None
            with closing(_opened(path)) as database:
                (version,) = database.execute(_QUERY).fetchone()
        elif address.is_server:
            return None
        else:
            import sqlalchemy

            engine = sqlalchemy.create_engine(
                address.uri, poolclass=sqlalchemy.NullPool, connect_args={"connect_timeout": _PATIENCE}
            )
            with engine.connect() as connection:
                version = connection.scalar(sqlalchemy.text(_QUERY))
    except Exception:  # of a driver: it cannot be reached, or has no tables yet
        return None
    return str(version)


def _opened(path: Path) -> sqlite3.Connection:
    if unwritable(path):
        return opened(path)
    return sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True, timeout=_PATIENCE)


@cache
def _versions() -> tuple[frozenset[str], str]:
    """Return all versions of the tables that the installed MLflow knows, and the newest; MLflow is not imported."""
    package = find_spec("mlflow")
    folder = Path(package.origin or "").parent / _VERSIONS if package else _VERSIONS
    own, previous = set[str](), set[str]()
    for file in folder.glob("*.py"):
        for earlier, version in _REVISION.findall(file.read_text(encoding="utf-8")):
            (previous if earlier else own).add(version)
    newest = own - previous
    return frozenset(own), newest.pop() if len(newest) == 1 else ""
