"""Each learner and textbook C of it do the same job, and the table shows the least times."""

from __future__ import annotations

import pandas as pd
import pytest

from benchmarks import learners


def test_the_least_times_are_compared():
    times = (("C", 50.0, 100.0), ("ours", 90.0, 99.0), ("C", 40.0, 100.0), ("ours", 60.0, 99.0))
    calls = pd.DataFrame([("Sarsa", *row) for row in times], columns=["learner", "who", "ns", "total_steps"])
    (row,) = learners.summary(calls).to_dict("records")
    assert (row["c_ns"], row["ours_ns"], row["ratio"]) == (40.0, 60.0, 1.5)
    assert row["difference"] == pytest.approx(-0.01)


def test_c_and_ours_need_as_many_steps():
    frame = learners.summary(learners.measure(2, lambda _: None))
    assert list(frame["learner"]) == list(learners.CASES)
    assert frame["difference"].abs().max() < 0.15
