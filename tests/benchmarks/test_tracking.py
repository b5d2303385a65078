"""Points are recorded by sweeps and in the naive way, and learned without being recorded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks import tracking
from tests.tracking.stores import copy_database

CASE = f"{tracking.OURS}, defaults, 1 of 1 cores learn"


def test_a_round_records_and_learns_in_every_way(empty_database: Path, tmp_path: Path):
    copy_database(empty_database, tmp_path / "mlflow.db")
    works = {"defaults": tracking.Work(("task.periods=5",), points=1, few=1, many=3)}
    calls = tracking.measure(
        1, lambda _: None, works=works, cores=1, naive_points=1, empty=tmp_path / "mlflow.db"
    ).set_index("case")
    assert list(calls.index) == [CASE, tracking.NAIVE]
    assert (calls.loc[CASE, ["slowed", "learn_ms"]] > 0).all()
    assert calls.loc[tracking.NAIVE, "cpu_ms"] > 0


def test_the_naive_way_is_compared_with_ours_within_a_round():
    calls = pd.DataFrame(
        [
            {"case": CASE, "round": 0, "cpu_ms": 40.0, "slowed": 1.01, "learn_ms": 17.0},
            {"case": tracking.NAIVE, "round": 0, "cpu_ms": 800.0, "slowed": np.nan},
            {"case": CASE, "round": 1, "cpu_ms": 60.0, "slowed": 1.03, "learn_ms": 17.0},
            {"case": tracking.NAIVE, "round": 1, "cpu_ms": 1800.0, "slowed": np.nan},
        ]
    )
    rows = tracking.summary(calls).set_index("case")
    assert rows.loc[tracking.NAIVE, "ratio"] == 25
    assert rows.loc[CASE, "ratio"] == 1
    assert rows.loc[CASE, "slowed"] == 1.02
    assert len(tracking.text_of(rows.reset_index())) == 2
