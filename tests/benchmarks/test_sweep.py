"""Sweeps of points that learn nothing are run here and by Hydra's own plugins."""

from __future__ import annotations

import pandas as pd

from benchmarks import sweep


def test_what_a_point_costs_is_the_slope_between_two_sweeps():
    sizes = {sweep.OURS: (2, 6), sweep.STOCK: (1, 2)}
    calls = sweep.measure(rounds=1, report=lambda _: None, sizes=sizes).set_index("case")
    assert calls["points"].to_dict() == {sweep.OURS: 4, sweep.STOCK: 1}
    assert calls["cpu_ms"].notna().all()
    assert calls.loc[sweep.STOCK, "files"] > calls.loc[sweep.OURS, "files"]


def test_ratios_are_taken_within_a_round():
    cpu = {sweep.OURS: (1.0, 2.0), sweep.STOCK: (10.0, 40.0)}
    calls = pd.DataFrame(
        [
            {"case": case, "round": round_, "points": 9, "cpu_ms": both[round_], "kib": 1.0, "files": 0}
            for round_ in (0, 1)
            for case, both in cpu.items()
        ]
    )
    rows = sweep.summary(calls).set_index("case")
    assert rows.loc[sweep.STOCK, "ratio"] == 15
    assert rows.loc[sweep.OURS, "ratio"] == 1
    assert len(sweep.text_of(rows.reset_index())) == 2
