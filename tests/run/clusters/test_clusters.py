"""Real clusters on this machine, through the real command line: identical results, and workers that are killed."""

from __future__ import annotations

import os
import signal
import sqlite3
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, suppress
from ipaddress import ip_address
from pathlib import Path
from socket import AF_UNIX, create_connection

import numpy as np
import psutil
import pytest

from tests.command_runner import Command, commands_in, finished, runs, started, wait_until
from tests.tracking.stores import copy_database

LAUNCHERS = ("design_dask", "design_ray")
SWEEP = ("-m", "task.periods=3", "task.trials=5", "representation=ad_hoc,direction", "world.size=4,5,6", "threads=2")
ROUGH = (*SWEEP, "world._target_=mine.Rough")

#: A world that fails at size 6. Its first worker at size 5 writes its process id and blocks, while later ones learn.
#: The planning process is recognised by the name of the command in its command line, which workers do not have.
OWN = """
import os
import time
from pathlib import Path
from rl_design_space.design import Torus

def plans():
    return b"rl-design-space" in Path("/proc/self/cmdline").read_bytes()

class Rough(Torus):
    def next_cell(self):
        if self.size == 6:
            raise RuntimeError("the floor of [6] is gone")
        mark = Path("out/worker")
        if self.size == 5 and not plans() and not mark.exists():
            mark.with_suffix(".new").write_text(str(os.getpid()))
            mark.with_suffix(".new").rename(mark)
            time.sleep(600)
        return super().next_cell()
"""


@pytest.fixture(scope="module", params=LAUNCHERS)
def launcher(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(scope="module")
def folder(launcher: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp(launcher)


@pytest.fixture(scope="module")
def command(folder: Path, empty_database: Path) -> Command:
    for outputs in ("there", "interrupted"):
        copy_database(empty_database, folder / "out" / outputs / "mlflow.db")
    return commands_with_own_module(folder, empty_database)


@pytest.fixture(scope="module")
def here(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[bytes, bytes]]:
    """The results of the sweep without a cluster."""
    folder = tmp_path_factory.mktemp("here")
    commands_with_own_module(folder, empty_database)("rl-design-space", *ROUGH, status=1, cold=True)
    return results(folder, "out")


def commands_with_own_module(folder: Path, database: Path) -> Command:
    run = commands_in(folder, database)
    (folder / "own" / "mine.py").write_text(OWN, encoding="utf-8")
    return run


def results(folder: Path, outputs: str) -> dict[str, tuple[bytes, bytes]]:
    """Return the recorded arrays of each point, by fingerprint."""
    query = """select t.value, r.artifact_uri from runs r join tags t using (run_uuid)
               where t.key = 'fingerprint' and r.status = 'FINISHED'"""
    with closing(sqlite3.connect(folder / outputs / "mlflow.db")) as database:
        found = database.execute(query).fetchall()
    assert len({fingerprint for fingerprint, _ in found}) == len(found), "a point is there twice"
    arrays = {fingerprint: np.load(Path(uri.removeprefix("file://")) / "periods.npz") for fingerprint, uri in found}
    return {name: (array["steps"].tobytes(), array["success"].tobytes()) for name, array in arrays.items()}


def open_doors(process: int) -> list[str]:
    """Return the sockets on which a process and its children let other users of this machine in.

    These are: any that other machines reach, a file in a folder that others can enter, and a port of Dask without TLS,
    which greets before it knows who is there.
    """
    family = [psutil.Process(process), *psutil.Process(process).children(recursive=True)]
    sockets = [socket for one in family for socket in one.net_connections("all")]
    ports = {socket.laddr for socket in sockets if socket.status == psutil.CONN_LISTEN}
    files = {Path(socket.laddr) for socket in sockets if socket.family == AF_UNIX and socket.laddr}
    assert ports
    reached = [f"{ip}:{port}" for ip, port in ports if not ip_address(ip.removeprefix("::ffff:")).is_loopback]
    shared = [str(path) for path in files if path.is_absolute() and not any(map(_is_private, path.parents))]
    with ThreadPoolExecutor(len(ports)) as pool:
        greeting = [place for place in pool.map(_greets_as_dask, ports) if place]
    return [*reached, *shared, *greeting]


def _is_private(folder: Path) -> bool:
    return folder.stat().st_mode & 0o077 == 0


def _greets_as_dask(place: tuple[str, int]) -> str:
    with create_connection(place, timeout=1) as connection, suppress(TimeoutError):
        return f"port {place[1]}" if b"compression" in connection.recv(1000) else ""
    return ""


def test_a_cluster_gives_identical_results_even_when_workers_are_killed_and_points_fail(
    launcher: str, command: Command, here: dict[str, tuple[bytes, bytes]], folder: Path
):
    there = (f"hydra/launcher={launcher}", "hydra.launcher.chunk=2", "outputs=out/there")
    with started(folder, *ROUGH, *there) as process:
        wait_until((folder / "out" / "worker").exists, process)
        assert open_doors(process.pid) == []
        os.kill(int((folder / "out" / "worker").read_text()), signal.SIGKILL)
        done = finished(process)
    assert (done.returncode, done.stderr) == (1, ""), done
    assert f"2 {launcher.removeprefix('design_').capitalize()} workers" in done.stdout
    assert "4 learned now, 0 before, 2 failed" in done.stdout
    assert "RuntimeError: the floor of [6] is gone" in done.stdout
    assert "mine.py:" in done.stdout
    assert runs(folder, "sweeps", "out/there") == [("sweep", "FAILED")]
    assert len(here) == 4
    assert here == results(folder, "out/there")


def test_an_interruption_ends_all_workers(launcher: str, command: Command, folder: Path):
    (folder / "out" / "worker").unlink(missing_ok=True)
    with started(folder, *ROUGH, f"hydra/launcher={launcher}", "outputs=out/interrupted") as process:
        wait_until((folder / "out" / "worker").exists, process)
        wait_until(lambda: runs(folder, "sweeps", "out/interrupted") == [("sweep", "RUNNING")], process, pause=0.05)
        process.send_signal(signal.SIGINT)
        done = finished(process)
    assert done.returncode == 130, done
    assert done.stderr.splitlines()[-1].startswith("interrupted; run the same command again")
    assert "Traceback" not in done.stderr
    worker = int((folder / "out" / "worker").read_text())
    wait_until(lambda: not _lives(worker))
    assert runs(folder, "sweeps", "out/interrupted")[-1] == ("sweep", "KILLED")


def _lives(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state != "Z"


def test_an_unreachable_cluster_is_reported_at_once(launcher: str, command: Command):
    # Nothing listens at this port.
    words = (*SWEEP, f"hydra/launcher={launcher}", "hydra.launcher.address=127.0.0.1:9", "tracking=none")
    (line,) = command("rl-design-space", *words, status=2).stderr.splitlines()
    assert line.startswith("error: hydra.launcher.address=127.0.0.1:9: no cluster can be reached there: ")
