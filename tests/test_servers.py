"""The services that other tests build on: databases are apart, and nothing is left behind.

That MLflow servers keep what they are given, go down and up and ask for a password is what other tests rely on.
"""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

from tests.command_runner import environment, finished, heed_interrupts, next_line, wait_until
from tests.servers import Postgres, needs_postgres
from tests.service import Service, free_port

ROOT = Path(__file__).parent.parent


@needs_postgres
def test_databases_are_apart_and_ask_for_their_password(postgres: Postgres):
    import psycopg

    one, other = postgres.create(), postgres.create()
    with closing(psycopg.connect(one)) as connection:
        connection.execute("create table mine (value int)")
        connection.commit()
    with closing(psycopg.connect(other)) as connection:
        assert connection.execute("select to_regclass('mine')").fetchone() == (None,)
    user, password = one.removeprefix("postgresql://").partition("@")[0].split(":")
    with pytest.raises(psycopg.OperationalError, match="password authentication failed"):
        psycopg.connect(one.replace(f"{user}:{password}", f"{user}:wrong"))


def test_a_service_that_ends_at_once_shows_its_log(tmp_path: Path):
    service = Service(
        command=["sh", "-c", "echo no such luck; exit 3"], ready=lambda: False, port=free_port(), log=tmp_path / "log"
    )
    with pytest.raises(RuntimeError, match="ended:\nno such luck"):
        service.start()
    assert not service.running


def test_a_port_that_is_taken_is_not_free():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", free_port()))
        taken.listen()
        assert taken.getsockname()[1] not in {free_port() for _ in range(50)}


# Runs a cluster, says where, and waits.
HOLDER = """
from tests.servers import postgres_cluster
with postgres_cluster() as cluster:
    print(cluster._process.pid, cluster.folder, flush=True)
    input()
"""


@needs_postgres
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL], ids=lambda how: how.name)
def test_a_cluster_ends_with_the_tests_however_they_end(tmp_path: Path, how: signal.Signals):
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLDER],
        cwd=ROOT,
        env={**environment(tmp_path), "PYTHONPATH": str(ROOT), "TMPDIR": "/tmp"},
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        preexec_fn=heed_interrupts,
    )  # fmt: skip
    pid, folder = next_line(holder).split()
    os.kill(int(pid), 0)
    holder.send_signal(how)
    finished(holder)
    wait_until(lambda: not Path(f"{folder}/data/postmaster.pid").exists())
    # A process that is killed cannot remove its files.
    assert Path(folder).exists() == (how == signal.SIGKILL)
    if how == signal.SIGKILL:
        shutil.rmtree(folder)
