"""Sweeps that are killed, and two sweeps at once, record every point exactly once."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from tests.command_runner import finished
from tests.run.kills import Store, killed_until_done, start
from tests.tracking.stores import copy_database

POINTS = 120
TINY = ("task.periods=3", "task.trials=20", f"seed=range(0,{POINTS})")


def stored(folder: Path) -> Store:
    return Store(folder / "outputs" / "mlflow.db")


def test_killed_sweeps_record_every_point_exactly_once(tmp_path: Path):
    figures = killed_until_done(tmp_path, TINY, POINTS, kills=5, seed=1)
    store = stored(tmp_path)
    assert figures.kills > 1
    assert figures.stages["some"] > 0
    assert store.finished() == Counter(dict.fromkeys(store.finished(), 1))
    assert len(store.finished()) == POINTS
    assert store.incomplete() == 0
    # Incomplete runs are marked KILLED, and the summary runs of killed sweeps are closed.
    assert set(store.statuses()) <= {"FINISHED", "KILLED"}
    assert store.sweeps()[-1] == "FINISHED" or store.statuses()["FINISHED"] == POINTS
    assert "RUNNING" not in store.sweeps()


@pytest.mark.parametrize("new", [True, False], ids=["new store", "old store"])
def test_two_sweeps_at_once_share_the_points(tmp_path: Path, empty_database: Path, new: bool):
    if not new:
        copy_database(empty_database, tmp_path / "outputs" / "mlflow.db")
    both = [start(tmp_path, *TINY) for _ in range(2)]
    ended = [finished(process) for process in both]
    assert [done.returncode for done in ended] == [0, 0], ended
    store = stored(tmp_path)
    assert store.finished() == Counter(dict.fromkeys(store.finished(), 1))
    assert store.statuses() == {"FINISHED": POINTS}
    assert store.incomplete() == 0
    assert store.sweeps() == ["FINISHED"] * 2
    assert not list((tmp_path / "outputs" / "spool").glob("*/*.record"))
    # Each says of all points what became of them, and together they have learned each once.
    learned = [int(done.stdout.split(" learned now")[0].split()[-1]) for done in ended]
    assert sum(learned) == POINTS
    assert all(f"sweep: {POINTS} points" in done.stdout and "0 failed" in done.stdout for done in ended)
