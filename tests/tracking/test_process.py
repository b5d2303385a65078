"""The tracker process by itself, when nobody listens to it any more."""

from __future__ import annotations

import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from rl_design_space.tracking.record import point_record
from rl_design_space.tracking.spool import Spool
from tests.command_runner import environment
from tests.tracking.stores import copy_database, learned, options

POINTS = 3
#: Seconds that delivering them may take.
_PATIENCE = 60


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
    until = time.monotonic() + _PATIENCE
    while spool.waiting() and time.monotonic() < until:
        # Who closes a database last cleans up after all others; whoever is there must be seen.
        finished(tmp_path / "mlflow.db")
        time.sleep(0.001)
    process.stdin.close()
    process.wait(_PATIENCE)
    assert spool.waiting() == []
    assert finished(tmp_path / "mlflow.db") == POINTS


def finished(database: Path) -> int:
    with closing(sqlite3.connect(database, timeout=30)) as reader:
        (count,) = reader.execute("select count(*) from runs where status = 'FINISHED'").fetchone()
    return count
