"""Stores to write tests with."""

from __future__ import annotations

import sqlite3
import warnings
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.plan.planner import plan_point
from rl_design_space.tracking import MlflowTracking
from rl_design_space.tracking.courier import Left
from rl_design_space.tracking.mlflow_tracker import MlflowTracker
from rl_design_space.tracking.spool import Spool
from rl_design_space.tracking.tracker import StoredRun
from rl_design_space.tracking.writer import deliver_all

if TYPE_CHECKING:
    from mlflow import MlflowClient

#: What a user has typed.
COMMAND = "rl-design-space study=mine world.size=4"
#: A point that costs nothing to learn.
TINY = ("task.periods=3", "task.trials=4", "world.size=4")


def import_mlflow() -> None:
    """Import what warns when it is imported: MLflow uses what its database library has deprecated."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        import mlflow.store.tracking.sqlalchemy_store  # noqa: F401


def options(database: Path, **others: object) -> MlflowTracking:
    return MlflowTracking(**{"uri": f"sqlite:///{database}", "spool": str(database.parent / "spool"), **others})


class AtOnce:
    """Delivers every record in this process as soon as it is written."""

    def __init__(self, options: MlflowTracking) -> None:
        self._spool = Spool.of(Path(options.spool), options.address)
        self.trouble = ""

    def watch(self, name: str, done: Callable[[], None]) -> None:
        self.trouble = deliver_all(self._spool, patience=0.1)
        if not self._spool.has(name):
            done()

    def settle(self, patience: float, told: object = None) -> Left:
        return Left(len(self._spool.waiting()), self.trouble)


def tracker_at(database: Path, command: str = "rl-design-space", **others: object) -> MlflowTracker:
    """A tracker that writes in this process."""
    chosen = options(database, **others)
    return chosen.open(command, AtOnce(chosen))


def record(tracker: MlflowTracker, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
    """Record a point, and find it in the store."""
    tracker.record(planned, curves)
    return tracker.finished([planned.fingerprint])[planned.fingerprint]


def plan_of(*points: PlannedPoint) -> Plan:
    """A plan of two studies."""
    return Plan(points, studies=("mine", "yours"))


def runs(client: MlflowClient, experiment: str = "design points") -> list:
    """All runs of an experiment."""
    return client.search_runs([client.get_experiment_by_name(experiment).experiment_id])


def copy_database(source: Path, target: Path) -> None:
    """A consistent copy, also of a database that others hold open."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with closing(sqlite3.connect(source)) as one, closing(sqlite3.connect(target)) as other:
        one.backup(other)


def learned(*overrides: str) -> tuple[PlannedPoint, LearningCurves]:
    planned = plan_point([*TINY, *overrides])
    return planned, simulate(planned.point, threads=1)
