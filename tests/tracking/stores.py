"""Stores, trackers and results for tests."""

from __future__ import annotations

import sqlite3
import warnings
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.tracking import MlflowTracking
from rl_design_space.tracking.delivery import deliver_all
from rl_design_space.tracking.mlflow_tracker import MlflowTracker
from rl_design_space.tracking.spool import Spool
from rl_design_space.tracking.tracker import DeliveryStatus, StoredRun
from tests.points import planned_point

if TYPE_CHECKING:
    from mlflow import MlflowClient

#: A command as typed.
COMMAND = "rl-design-space study=mine world.size=4"
#: Overrides of a point that is learned within milliseconds.
TINY = ("task.periods=3", "task.trials=4", "world.size=4")


def import_mlflow() -> None:
    """Import MLflow without its warnings: it uses deprecated parts of its database library."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        import mlflow.store.tracking.sqlalchemy_store  # noqa: F401


def options(database: Path, **others: object) -> MlflowTracking:
    """Return the options of tracking with a database."""
    return MlflowTracking(**{"uri": f"sqlite:///{database}", "spool": str(database.parent / "spool"), **others})


class ImmediateDelivery:
    """Delivers every record in this process as soon as it is written."""

    def __init__(self, options: MlflowTracking) -> None:
        self._spool = Spool.of(Path(options.spool), options.address)
        self._problem = ""

    def watch(self, name: str, on_delivery: Callable[[], None]) -> None:
        self._problem = deliver_all(self._spool, patience=0.1)
        if not self._spool.has(name):
            on_delivery()

    def wait(self, patience: float, on_progress: object = None) -> DeliveryStatus:
        return DeliveryStatus(len(self._spool.pending()), self._problem)


class NoDelivery:
    """Delivers nothing."""

    def watch(self, name: str, on_delivery: Callable[[], None]) -> None:
        pass


def tracker_at(database: Path, command: str = "rl-design-space", **others: object) -> MlflowTracker:
    """Return a tracker that delivers in this process."""
    chosen = options(database, **others)
    return chosen.open(command, ImmediateDelivery(chosen))


def undelivered_tracker_at(database: Path, **others: object) -> MlflowTracker:
    """Return a tracker whose records stay pending."""
    chosen = options(database, **others)
    return MlflowTracker(
        chosen.address,
        Path(chosen.spool),
        "rl-design-space",
        location=chosen.uri,
        patience=chosen.patience,
        delivery=NoDelivery(),
        retry_pause=0.01,
    )


def record(tracker: MlflowTracker, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
    """Record a point; return its run."""
    tracker.record(planned, curves)
    return tracker.finished([planned.fingerprint])[planned.fingerprint]


def plan_of(*points: PlannedPoint) -> Plan:
    """Return a plan of two studies."""
    return Plan(points, studies=("mine", "yours"))


def runs(client: MlflowClient, experiment: str = "design points") -> list:
    """Return all runs of an experiment."""
    return client.search_runs([client.get_experiment_by_name(experiment).experiment_id])


def copy_database(source: Path, target: Path) -> None:
    """Copy a database consistently, even if other connections to it are open."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with closing(sqlite3.connect(source)) as one, closing(sqlite3.connect(target)) as other:
        one.backup(other)


def learned(*overrides: str) -> tuple[PlannedPoint, LearningCurves]:
    """Return a tiny point and its result."""
    planned = planned_point([*TINY, *overrides])
    return planned, simulate(planned.point, threads=1)
