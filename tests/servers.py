"""Tracking servers as a team has them: PostgreSQL, and MLflow in front of it, each of the tests' own."""

from __future__ import annotations

import os
import pwd
import secrets
import shutil
import signal
import subprocess
import tempfile
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.command_runner import PATIENCE, SCRIPTS, environment
from tests.service import Service, free_port

if TYPE_CHECKING:
    import psycopg


def _server_programs() -> Path | None:
    """Folder of initdb and postgres: the newest that Debian has, or the one on the PATH."""
    debian = Path("/usr/lib/postgresql").glob("*/bin/initdb")
    found = max(debian, key=lambda path: float(path.parts[-3]), default=shutil.which("initdb"))
    return None if found is None else Path(found).parent


PROGRAMS = _server_programs()

needs_postgres = pytest.mark.skipif(PROGRAMS is None, reason="needs PostgreSQL's server (apt-get install postgresql)")


class Postgres(Service):
    """A cluster of databases in a folder that goes with it.

    Its superuser comes in through a socket in that folder; whoever comes over TCP has to give a password.
    """

    def __init__(self, folder: Path):
        """Create the cluster.

        Args:
            folder: empty, and owned by the user that the server is to run as.
        """
        user = pwd.getpwuid(folder.stat().st_uid).pw_name
        other = None if os.geteuid() else user
        port = free_port()
        super().__init__(
            command=[
                *(str(PROGRAMS / "postgres"), "-D", str(folder / "data"), "-k", str(folder), "-p", str(port)),
                *("-c", "listen_addresses=127.0.0.1"),
                # It is thrown away in any case.
                *("-c", "fsync=off", "-c", "synchronous_commit=off", "-c", "full_page_writes=off"),
            ],
            ready=self._answers,
            port=port,
            log=folder / "log",
            user=other,
            ending=signal.SIGINT,  # disconnects clients
        )
        self.folder = folder
        self._names = (f"database_{number}" for number in count(1))
        done = subprocess.run(
            [
                *(PROGRAMS / "initdb", "--pgdata", folder / "data", "--username=postgres", "--no-sync"),
                *("--encoding=UTF8", "--locale=C", "--auth-local=trust", "--auth-host=scram-sha-256"),
            ],
            capture_output=True,
            text=True,
            cwd=folder,
            user=other,
            extra_groups=None if other is None else [],
            timeout=PATIENCE,
        )
        if done.returncode:
            raise RuntimeError(done.stdout + done.stderr)

    def create(self, name: str | None = None, password: str | None = None) -> str:
        """Make an empty database and a role of the same name that owns it.

        Returns:
            Its URI, with the password.
        """
        from psycopg import sql

        name, password = name or next(self._names), password or secrets.token_hex(8)
        with self._superuser() as connection:
            connection.execute(
                sql.SQL("create role {} login password {}").format(sql.Identifier(name), sql.Literal(password))
            )
            connection.execute(sql.SQL("create database {0} owner {0}").format(sql.Identifier(name)))
        return f"postgresql://{name}:{password}@127.0.0.1:{self.port}/{name}"

    def _superuser(self) -> psycopg.Connection:
        import psycopg

        where = {"host": str(self.folder), "port": self.port, "dbname": "postgres"}
        return psycopg.connect(user="postgres", autocommit=True, **where)

    def _answers(self) -> bool:
        import psycopg

        try:
            self._superuser().close()
        except psycopg.OperationalError:
            return False
        return True


@contextmanager
def postgres_cluster() -> Iterator[Postgres]:
    """A cluster that runs, in a temporary folder."""
    # Not among the temporary folders of pytest: nobody else may enter these, and a socket's path has to be short.
    folder = Path(tempfile.mkdtemp(prefix="postgres-"))
    try:
        if os.geteuid() == 0:  # PostgreSQL refuses to run as root
            names = {entry.pw_name for entry in pwd.getpwall()}
            shutil.chown(folder, "postgres" if "postgres" in names else "nobody")
        with Postgres(folder) as cluster:
            yield cluster
    finally:
        shutil.rmtree(folder)


class HttpService(Service):
    """A program that is ready when it answers at /health."""

    def __init__(self, *, command: list[str], environment: dict[str, str], port: int, folder: Path):
        super().__init__(
            command=command, environment=environment, ready=self._healthy, port=port, log=folder / "server.log"
        )
        self.uri = f"http://127.0.0.1:{port}"

    def _healthy(self) -> bool:
        try:
            with urllib.request.urlopen(f"{self.uri}/health", timeout=5) as answer:
                return answer.status == 200
        except (urllib.error.URLError, OSError):
            return False


class MlflowServer(HttpService):
    """`mlflow server`, as lean as it goes.

    Attributes:
        uri: of the server.
        username: of the administrator; None without basic auth.
        password: of the administrator; None without basic auth.
    """

    username: str | None = None
    password: str | None = None

    def __init__(self, backend: str, folder: Path, *, auth: bool = False):
        """Describe a server; `start` runs it.

        Args:
            backend: URI of its database.
            folder: for its artifacts and its log.
            auth: whether it asks for a user's name and password.
        """
        port = free_port()
        lean = {"MLFLOW_SERVER_ENABLE_JOB_EXECUTION": "false", "MLFLOW_DISABLE_TELEMETRY": "true"}
        variables = {**environment(folder, **lean), "MLFLOW_BACKEND_STORE_URI": backend, "TMPDIR": str(folder)}
        command = [
            *(str(SCRIPTS / "mlflow"), "server", "--host", "127.0.0.1", "--port", str(port), "--workers", "1"),
            *("--artifacts-destination", str(folder / "artifacts")),
        ]
        if auth:
            self.username, self.password = "admin", secrets.token_hex(8)
            config = folder / "basic_auth.ini"
            config.write_text(_AUTH.format(**vars(self), backend=backend), encoding="utf-8")
            variables |= {
                "MLFLOW_AUTH_CONFIG_PATH": str(config),
                "MLFLOW_FLASK_SERVER_SECRET_KEY": secrets.token_hex(16),
            }
            command += ["--app-name", "basic-auth"]
        super().__init__(command=command, environment=variables, port=port, folder=folder)


# Without the cache every request costs a tenth of a second and more, which goes into hashing the password.
_AUTH = """\
[mlflow]
default_permission = READ
database_uri = {backend}
admin_username = {username}
admin_password = {password}
auth_cache_ttl_seconds = 60
"""


@pytest.fixture(scope="session")
def postgres() -> Iterator[Postgres]:
    """A cluster that all tests share; `postgres.create()` makes a database of a test's own."""
    with postgres_cluster() as cluster:
        yield cluster


@pytest.fixture(scope="session")
def _shared_mlflow_server(postgres: Postgres, tmp_path_factory: pytest.TempPathFactory) -> Iterator[MlflowServer]:
    server = MlflowServer(postgres.create(), tmp_path_factory.mktemp("mlflow_server"))
    yield server
    server.stop()


@pytest.fixture
def mlflow_server(_shared_mlflow_server: MlflowServer) -> MlflowServer:
    """A server on PostgreSQL that all tests share, running; tests that stop it need not start it again."""
    if not _shared_mlflow_server.running:
        _shared_mlflow_server.start()
    return _shared_mlflow_server


@pytest.fixture
def idle_mlflow_server(_shared_mlflow_server: MlflowServer) -> MlflowServer:
    """The same server, not running; for a test that needs it down first, which saves a start if no test has run it."""
    _shared_mlflow_server.stop()
    return _shared_mlflow_server


@pytest.fixture(scope="session")
def auth_server(postgres: Postgres, tmp_path_factory: pytest.TempPathFactory) -> Iterator[MlflowServer]:
    """The same with basic auth; its administrator is `auth_server.username`, `auth_server.password`."""
    with MlflowServer(postgres.create(), tmp_path_factory.mktemp("auth_server"), auth=True) as server:
        yield server
