"""Several processes record into one store."""

from __future__ import annotations

import pandas as pd

from benchmarks import writers
from benchmarks.writer import CLIENT, OURS


def test_points_are_recorded_by_several_writers():
    calls = writers.measure(1, lambda _: None, points={writers.SQLITE: 2}, ways=((OURS, 2),))
    assert calls[["way", "writers"]].to_numpy().tolist() == [[OURS, 2]]
    assert (calls[["rate", "cpu_ms", "in_transactions_ms"]] > 0).all(axis=None)


def test_ways_are_compared_with_one_writer_of_ours_within_a_round():
    rows = [
        {"round": round_, "way": way, "writers": several, "cpu_ms": cpu[round_]}
        for round_ in (0, 1)
        for way, several, cpu in ((OURS, 1, (10, 20)), (OURS, 2, (11, 22)), (CLIENT, 1, (50, 140)))
    ]
    frame = pd.DataFrame(rows).assign(store=writers.SQLITE, rate=1.0, in_transactions_ms=1.0, store_ms=0.0)
    summary = writers.summary(frame)
    assert summary["ratio"].tolist() == [1, 1.1, 6]
    assert len(writers.text_of(summary)) == 3
