"""The benchmark of reports and of loading runs."""

from __future__ import annotations

import pandas as pd

from benchmarks import reports
from benchmarks.reports import CLIENT, OURS


def test_ways_to_load_are_compared_by_store():
    rows = [("fig1", "", 2.0), (OURS, "database", 1.0), (CLIENT, "database", 20.0), (OURS, "server", 5.0)]
    calls = pd.DataFrame(
        [{"case": case, "store": store, "round": 0, "seconds": s, "cpu": s} for case, store, s in rows]
    )
    frame = reports.summary(calls).set_index(["case", "store"])
    assert frame.loc[(CLIENT, "database"), "ratio"] == 20
    assert frame.loc[(OURS, "server"), "ratio"] == 1
    text = reports.text_of(frame.reset_index())
    assert list(text["what"]) == ["fig1", f"{OURS}, database", f"{CLIENT}, database", f"{OURS}, server"]
    assert text["over ours"].iloc[0] == ""
