"""Whole commands are started beside their imports alone."""

from __future__ import annotations

import numpy as np
import pandas as pd

from benchmarks import start


def test_every_command_is_started_in_every_round():
    calls = start.measure(rounds=1, report=lambda _: None)
    assert calls["case"].tolist() == [start.BARE, start.FLOOR, start.HELP, start.ONE, start.DEFAULT]
    assert (calls["seconds"] > 0).all()
    peak = calls.set_index("case")["peak_mib"]
    # What only imports, imports about what the command does; bare Python does not.
    assert peak[start.BARE] < peak[start.FLOOR] / 2
    assert peak[start.FLOOR] > peak[start.ONE] / 2


def test_time_beyond_the_imports_is_taken_within_a_round():
    seconds = {start.BARE: (0.1, 0.1), start.FLOOR: (1.0, 2.0), start.ONE: (1.5, 2.5)}
    calls = pd.DataFrame(
        [
            {"case": case, "round": round_, "seconds": both[round_], "peak_mib": 1.0}
            for round_ in (0, 1)
            for case, both in seconds.items()
        ]
    )
    rows = start.summary(calls).set_index("case")
    assert rows.loc[start.ONE, "beyond_imports"] == 0.5
    assert np.isnan(rows.loc[start.BARE, "beyond_imports"])
    assert len(start.text_of(rows.reset_index())) == 3
