"""A small Table 4 in a store of its own: tiny points, made-up published numbers, two cells not run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pytest

from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.plan.study import Study
from rl_design_space.report import PublishedTable
from rl_design_space.tracking.read import RunReader
from tests.points import shipped_study
from tests.tracking.stores import import_mlflow, options, tracker_at

OVERRIDES = ["task.periods=20", "task.trials=5", "world.size=4,5"]
PUBLISHED = {
    "ad_hoc": {4: {1: 150, 2: 180, 3: 260}, 5: {1: 200, 2: 250, 3: 400}},
    "direction": {4: {1: 110, 2: 240, 3: 360}, 5: {1: 280, 2: 540, 3: 610}},
}
#: Representation, size, goals.
Cell = tuple[str, int, int]
MISSING: set[Cell] = {("direction", 4, 3), ("direction", 5, 1)}


def cell_of(planned) -> Cell:
    return tuple(planned.parameters[name] for name in ("representation", "world.size", "task.goals"))


class Small(NamedTuple):
    """The study, its report, what was learned, and the store that holds it."""

    study: Study
    table: PublishedTable
    learned: dict[Cell, LearningCurves]
    reader: RunReader


@pytest.fixture(scope="package")
def small(tmp_path_factory: pytest.TempPathFactory) -> Small:
    import_mlflow()
    database = tmp_path_factory.mktemp("table4") / "mlflow.db"
    tracker = tracker_at(database)
    study = shipped_study("table4", *OVERRIDES)
    learned = {}
    for planned in study.plan:
        if cell_of(planned) not in MISSING:
            learned[cell_of(planned)] = simulate(planned.point, threads=1)
            tracker.record(planned, learned[cell_of(planned)])
    return Small(study, replace(study.report(), published=PUBLISHED), learned, options(database).reader())


@pytest.fixture(scope="package")
def written(small: Small, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The files of the small report, by suffix."""
    folder = tmp_path_factory.mktemp("report") / "new"
    return {path.suffix: path for path in small.table.write(small.study, small.reader, folder)}
