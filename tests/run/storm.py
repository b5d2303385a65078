"""Storms: sweeps that are killed repeatedly, in other folders, on other hosts, from several outputs into one store.

`python -m tests.run.storm --kills 1000` prints a table: kills, and points that were lost, doubled or left unfinished.
"""

from __future__ import annotations

import argparse
import math
import os
import random
import shutil
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import mkdtemp
from time import monotonic, sleep

import psutil
import sqlalchemy
from rich.console import Console
from rich.table import Table

from rl_design_space.tracking.spool import Spool
from tests.command_runner import PATIENCE
from tests.run.kills import COMMAND
from tests.servers import postgres_cluster

#: Points that are new in each sweep, two transactions of them; those before are stored, pending, or not yet learned.
POINTS = 60
SWEEP = ("-m", "task.periods=3", "task.trials=10", "threads=2")
TRACKER = "rl_design_space.tracking.process"
#: Kills until a storm is over, and its points are counted.
ROUND = 10
#: What a kill waits for: a time after the start, a number of points that are learned, or a change of the store.
MOMENTS = ("any", "learned", "stored")
#: How far a sweep had come when it was killed: nothing, points learned but not stored, some points stored, all of them.
STAGES = ("none", "learned", "some", "all")


@dataclass(frozen=True)
class Weather:
    """A kind of storm.

    Attributes:
        name: for the table.
        outputs: number of outputs that record into one store.
        victim: `group`, `command` or `tracker`.
        hosts: whether each command runs under another host name.
        moves: whether the folder is moved between commands.
        postgres: whether the store is a PostgreSQL database instead of a SQLite file.
    """

    name: str
    outputs: int = 1
    victim: str = "group"
    hosts: bool = False
    moves: bool = False
    postgres: bool = False


KINDS = (
    Weather("all processes"),
    Weather("the command alone", victim="command"),
    Weather("the tracker process alone", victim="tracker"),
    Weather("other host names", hosts=True),
    Weather("the folder moves", moves=True),
    Weather("two outputs, one SQLite file", outputs=2),
    Weather("two outputs, one SQLite file, other host names", outputs=2, hosts=True),
    Weather("PostgreSQL, two outputs", outputs=2, postgres=True),
    Weather("PostgreSQL, two outputs, other host names", outputs=2, hosts=True, postgres=True),
)


@dataclass
class Damage:
    """What storms of a kind have done.

    Attributes:
        kills: commands or tracker processes that were killed.
        stages: number of kills by how far the sweep had come, one of `STAGES`.
        lost, doubled: points without a complete run, and with several.
        stuck: RUNNING runs and pending records.
        tracebacks: commands that ended with one.
    """

    kills: int = 0
    stages: Counter[str] = field(default_factory=Counter)
    lost: int = 0
    doubled: int = 0
    stuck: int = 0
    tracebacks: int = 0


class Storm:
    """Kills sweeps in a folder.

    Args:
        weather: kind of storm.
        chance: decides who is killed, and when.
        uri: of the store, with a password; a SQLite file in the folder if empty.
    """

    def __init__(self, weather: Weather, chance: random.Random, uri: str = "") -> None:
        self._weather, self._chance = weather, chance
        self._folder = Path(mkdtemp(prefix="storm-"))
        self._points = POINTS
        self._usual = 0.0  # seconds that a sweep takes
        self._url = sqlalchemy.make_url(uri) if uri else None
        self.damage = Damage()

    def run(self) -> Damage:
        """Measure how long a sweep takes, kill, let the sweeps end, and count."""
        begin = monotonic()
        self._finish([self._start(0)])
        self._usual = monotonic() - begin
        self._points += POINTS
        while self.damage.kills < ROUND:
            self._kill_one()
            if self._weather.moves:
                moved = self._folder.with_name(f"storm-moved-{self._chance.getrandbits(40):x}")
                self._folder = self._folder.rename(moved)
        outputs = range(self._weather.outputs)
        self._finish([*map(self._start, outputs), *(self._start(number, "sync") for number in outputs)])  # at once
        points, running = self._stored()
        self.damage.lost = self._points - len(points)
        self.damage.doubled = sum(count - 1 for count in points.values())
        spools = [spool for place in self._folder.glob("out*/spool") for spool in Spool.all_under(place)]
        self.damage.stuck = running + sum(len(spool.pending()) for spool in spools)
        if not (self.damage.lost or self.damage.doubled or self.damage.stuck or self.damage.tracebacks):
            shutil.rmtree(self._folder)
        return self.damage

    def _finish(self, processes: list[subprocess.Popen[str]]) -> None:
        for process in processes:
            output, _ = process.communicate(timeout=PATIENCE)
            if output.startswith("error:"):  # then no sweep gets so far that killing it shows anything
                raise RuntimeError(output)
            self.damage.tracebacks += "Traceback" in output

    def _kill_one(self) -> None:
        before = len(self._stored()[0])
        begin, process = monotonic(), self._start(self._chance.randrange(self._weather.outputs))
        self._wait(process, self._chance.choice(MOMENTS), before)
        if process.poll() is not None:  # it has ended by itself: the next one has to be killed sooner
            self._usual = monotonic() - begin
        elif self._strike(process):
            self.damage.kills += 1
            self.damage.stages[self._stage(before)] += 1
        if self._weather.victim == "command":
            sleep(self._chance.uniform(0, 0.5))  # its tracker process notices
        self._finish([process])
        self._points += POINTS

    def _wait(self, process: subprocess.Popen[str], moment: str, before: int) -> None:
        """Wait until a sweep has come so far that it is to be killed, or has ended."""
        until = monotonic() + self._chance.uniform(0.3, 1.1) * self._usual
        if moment == "learned":
            number = self._pending() + self._chance.randint(1, POINTS)
            _sleep_until(process, lambda: self._pending() >= number or len(self._stored()[0]) > before)
            until = 0
        elif moment == "stored":
            _sleep_until(process, lambda: len(self._stored()[0]) > before)
            until = monotonic() + self._chance.uniform(0, 1)  # a transaction takes half a second
        _sleep_until(process, lambda: monotonic() > until)

    def _stage(self, before: int) -> str:
        new = len(self._stored()[0]) - before
        if new:
            return "all" if new == self._points - before else "some"
        return "learned" if self._pending() else "none"

    def _pending(self) -> int:
        """Return the number of records that wait to be stored."""
        return sum(1 for _ in self._folder.glob("out*/spool/*/*-point-*.record"))

    def _strike(self, process: subprocess.Popen[str]) -> bool:
        if self._weather.victim == "group":
            os.killpg(process.pid, signal.SIGKILL)
        elif self._weather.victim == "command":
            process.kill()
        else:
            trackers = _trackers(process.pid)
            for tracker in trackers:
                tracker.kill()
            return bool(trackers)
        return True

    def _start(self, number: int, *words: str) -> subprocess.Popen[str]:
        variables, stores = dict(os.environ), []
        if self._url:
            variables["PGPASSWORD"] = str(self._url.password)
            stores = ["tracking=server", f"tracking.uri={self._url._replace(password=None).render_as_string()}"]
        elif self._weather.outputs > 1:
            stores = [f"tracking.uri={self._store.render_as_string()}"]
        outputs = f"outputs={self._folder}/out{number}"
        command = [str(COMMAND), *(words or (*SWEEP, f"seed=range(0,{self._points})")), outputs, *stores]
        if self._weather.hosts:
            name = f"host-{self._chance.getrandbits(20):x}"
            command = ["unshare", "--uts", "sh", "-c", f'hostname {name}; exec "$@"', "sh", *command]
        pipe = subprocess.PIPE
        return subprocess.Popen(
            command, env=variables, stdout=pipe, stderr=subprocess.STDOUT, text=True, start_new_session=True
        )

    @property
    def _store(self) -> sqlalchemy.URL:
        shared = "shared" if self._weather.outputs > 1 else "out0"
        return self._url or sqlalchemy.URL.create("sqlite", database=f"{self._folder}/{shared}/mlflow.db")

    def _stored(self) -> tuple[Counter[str], int]:
        """Return the number of complete runs by fingerprint, and the number of RUNNING runs."""
        engine = sqlalchemy.create_engine(self._store, poolclass=sqlalchemy.NullPool)
        if not self._url and not Path(str(self._store.database)).exists():
            return Counter(), 0
        with engine.connect() as connection:
            if not sqlalchemy.inspect(connection).has_table("tags"):
                return Counter(), 0
            finished = connection.scalars(sqlalchemy.text(_FINISHED)).all()
            return Counter(finished), connection.scalar(sqlalchemy.text(_RUNNING)) or 0


_FINISHED = """
    select t.value from runs r join tags t on t.run_uuid = r.run_uuid
    where t.key = 'fingerprint' and r.status = 'FINISHED'
"""
_RUNNING = "select count(*) from runs where status = 'RUNNING'"


def _sleep_until(process: subprocess.Popen[str], happened: Callable[[], bool]) -> None:
    """Sleep until something has happened, or the process has ended."""
    while process.poll() is None and not happened():
        sleep(0.01)


def _trackers(process: int) -> list[psutil.Process]:
    """Return the tracker processes that a command has started."""
    try:
        return [child for child in psutil.Process(process).children(recursive=True) if TRACKER in child.cmdline()]
    except psutil.NoSuchProcess:
        return []


def main() -> int:
    """Run storms of all kinds, two at a time.

    Returns:
        Exit status: 1 if anything was lost, doubled or stuck.
    """
    parser = argparse.ArgumentParser(prog="python -m tests.run.storm", description=__doc__)
    parser.add_argument("--kills", type=int, default=90, help="in all")
    parser.add_argument("--seed", type=int, default=1, help="of the times and the victims")
    parser.add_argument("--only", default="", help="kinds whose name contains this, e.g. PostgreSQL")
    chosen = parser.parse_args()
    kinds = [kind for kind in KINDS if chosen.only in kind.name]
    rounds = math.ceil(chosen.kills / (ROUND * len(kinds)))
    found = {kind.name: Damage() for kind in kinds}
    with ExitStack() as stack:
        cluster = stack.enter_context(postgres_cluster())
        storms = []
        for number in range(rounds):
            for kind in kinds:
                uri = cluster.create() if kind.postgres else ""
                storms.append((kind, Storm(kind, random.Random(f"{chosen.seed} {number} {kind}"), uri)))
        pool = stack.enter_context(ThreadPoolExecutor(2))
        for (kind, _), damage in zip(storms, pool.map(lambda pair: pair[1].run(), storms), strict=True):
            print(kind.name, damage, file=sys.stderr, flush=True)
            total = found[kind.name]
            total.stages += damage.stages
            for name in ("kills", "lost", "doubled", "stuck", "tracebacks"):
                setattr(total, name, getattr(total, name) + getattr(damage, name))
    table = Table("killed", "kills", " / ".join(STAGES), "lost", "doubled", "stuck", "tracebacks")
    for name, total in found.items():
        stages = " / ".join(str(total.stages[stage]) for stage in STAGES)
        table.add_row(name, *map(str, (total.kills, stages, total.lost, total.doubled, total.stuck, total.tracebacks)))
    Console(width=120).print(table)
    return int(any(total.lost or total.doubled or total.stuck for total in found.values()))


if __name__ == "__main__":
    sys.exit(main())
