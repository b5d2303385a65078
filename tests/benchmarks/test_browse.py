"""A database is filled, and the pages that people wait for are asked for."""

from __future__ import annotations

from benchmarks import browse


def test_everything_is_asked_for_twice():
    said: list[str] = []
    calls = browse.measure(rounds=1, report=said.append, runs=9, learned=2)
    assert said[0].startswith("browse: 9 runs, ")
    assert (calls["seconds"] > 0).all()
    rows = browse.summary(calls).set_index("request")
    assert list(rows.index) == ["a chart of 100 runs", "load_runs, all runs", "table, first page"]
    assert rows[["cold", "warm"]].notna().all().all()
    assert len(browse.text_of(rows.reset_index())) == 3
