"""Sweeps through the real command line that are killed repeatedly."""

from __future__ import annotations

import random
import signal
import sqlite3
import subprocess
import sysconfig
from collections import Counter
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic, sleep

from tests.command_runner import PATIENCE, finished

COMMAND = Path(sysconfig.get_path("scripts")) / "rl-design-space"


@dataclass
class Store:
    """The runs in the database of a sweep."""

    database: Path

    def statuses(self) -> Counter[str]:
        """Return the number of runs by status; empty before there is a database."""
        return Counter(status for _, status in self._points())

    def finished(self) -> Counter[str]:
        """Return the number of complete runs by fingerprint."""
        return Counter(fingerprint for fingerprint, status in self._points() if status == "FINISHED")

    def sweeps(self) -> list[str]:
        """Return the statuses of the summary runs, in order."""
        return [status for (status,) in self._ask("select status from runs where name = 'sweep' order by start_time")]

    def incomplete(self) -> int:
        """Return the number of FINISHED runs without params, curves or artifact."""
        query = """
            select artifact_uri, (select count(*) from params p where p.run_uuid = r.run_uuid),
                   (select count(*) from metrics m where m.run_uuid = r.run_uuid)
            from runs r join tags t using (run_uuid) where t.key = 'fingerprint' and r.status = 'FINISHED'
        """
        found = self._ask(query)
        sizes = {(params, metrics) for _, params, metrics in found}
        lacking = [uri for uri, _, _ in found if not (Path(uri.removeprefix("file://")) / "periods.npz").exists()]
        return len(lacking) + max(len(sizes) - 1, 0)

    def _points(self) -> list[tuple[str, str]]:
        return self._ask(
            "select t.value, r.status from runs r join tags t using (run_uuid) where t.key = 'fingerprint'"
        )

    def _ask(self, query: str) -> list[tuple]:
        if not self.database.exists():
            return []
        with closing(sqlite3.connect(self.database, timeout=30)) as database:
            tables = database.execute("select name from sqlite_master where name in ('runs', 'tags', 'metrics')")
            return database.execute(query).fetchall() if len(tables.fetchall()) == 3 else []


@dataclass
class Figures:
    """The result of killing a sweep repeatedly."""

    kills: int = 0
    #: Number of kills by whether the database held no, some or all points.
    stages: Counter[str] = field(default_factory=Counter)


def start(folder: Path, *words: str) -> subprocess.Popen[str]:
    """Start a sweep in a folder, in its own process group."""
    pipe = subprocess.PIPE
    command = [str(COMMAND), "-m", "threads=2", *words]
    return subprocess.Popen(command, cwd=folder, stdout=pipe, stderr=pipe, text=True, start_new_session=True)


def killed_until_done(folder: Path, words: tuple[str, ...], points: int, kills: int, seed: int) -> Figures:
    """Run a sweep repeatedly, killing it at random times, then once more until it ends.

    Half of the kills come at any time after the start, the others right after the store has changed.
    """
    chance, figures, store = random.Random(seed), Figures(), Store(folder / "outputs" / "mlflow.db")
    while figures.kills < kills:
        before = store.statuses()
        if before["FINISHED"] == points:
            break
        process = start(folder, *words)
        begun, wait = monotonic(), chance.uniform(0.2, 6)
        if figures.kills % 2:
            while store.statuses() == before and process.poll() is None and monotonic() - begun < PATIENCE:
                sleep(0.005)
            wait = chance.uniform(0, 0.05)  # a batch takes half a second
            begun = monotonic()
        while process.poll() is None and monotonic() - begun < wait:
            sleep(0.005)
        if process.poll() is None:
            process.send_signal(signal.SIGKILL)
            figures.kills += 1
            after = store.statuses()
            figures.stages["none" if not after else "all" if after["FINISHED"] == points else "some"] += 1
        finished(process)
    done = finished(start(folder, *words))
    assert done.returncode == 0, done.stdout + done.stderr
    return figures
