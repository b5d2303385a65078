"""The tracker process by itself, when nobody listens to it any more."""

from __future__ import annotations

import sqlite3
import subprocess
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from rl_design_space.tracking.record import point_record
from rl_design_space.tracking.spool import Spool
from tests.command_runner import PATIENCE, environment, wait_until
from tests.tracking.stores import copy_database, learned, options

POINTS = 3


@pytest.fixture
def spool(empty_database: Path, tmp_path: Path) -> Spool:
    """A few points on their way into a database."""
    copy_database(empty_database, tmp_path / "mlflow.db")
    (tmp_path / "temporary").mkdir()
    chosen = options(tmp_path / "mlflow.db")
    spool = Spool.of(Path(chosen.spool), chosen.address)
    for seed in range(POINTS):
        planned, curves = learned(f"seed={seed}")
        spool.write(point_record(replace(planned, studies=("mine",)), curves, {}))
    return spool


def test_nothing_is_lost_that_others_read_meanwhile_when_the_sweep_has_died(spool: Spool, tmp_path: Path):
    command = [sys.executable, "-m", "rl_design_space.tracking.process", str(spool.folder), "hurry"]
    process = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=tmp_path, env=environment(tmp_path)
    )
    process.stdout.close()

    def delivered() -> bool:
        finished(tmp_path / "mlflow.db")  # opens and closes the database: the last to close it removes its log
        return not spool.waiting()

    wait_until(delivered, pause=0.001)
    process.stdin.close()
    process.wait(PATIENCE)
    assert finished(tmp_path / "mlflow.db") == POINTS


def finished(database: Path) -> int:
    with closing(sqlite3.connect(database, timeout=30)) as reader:
        (count,) = reader.execute("select count(*) from runs where status = 'FINISHED'").fetchone()
    return count
