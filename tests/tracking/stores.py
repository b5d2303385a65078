"""Stores to write tests with."""

from __future__ import annotations

import sqlite3
import warnings
from contextlib import closing
from pathlib import Path

from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.sweep.compose import compose
from rl_design_space.sweep.plan import PlannedPoint
from rl_design_space.tracking import MlflowTracking

#: A point that costs nothing to learn.
TINY = ("task.periods=3", "task.trials=4", "world.size=4")


def import_mlflow() -> None:
    """Import what warns when it is imported: MLflow uses what its database library has deprecated."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        import mlflow.store.tracking.sqlalchemy_store  # noqa: F401


def options(database: Path, **others: object) -> MlflowTracking:
    return MlflowTracking(uri=f"sqlite:///{database}", **others)


def copy_database(source: Path, target: Path) -> None:
    """A consistent copy, also of a database that others hold open."""
    with closing(sqlite3.connect(source)) as one, closing(sqlite3.connect(target)) as other:
        one.backup(other)


def learned(*overrides: str) -> tuple[PlannedPoint, LearningCurves]:
    planned = compose([*TINY, *overrides])
    return planned, simulate(planned.point, threads=1)
