"""Which points are stored is found alike in all ways: one by one, from the database, and page by page."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from rl_design_space.tracking import index
from rl_design_space.tracking.tracker import StoredRun
from tests.tracking.stores import learned, options

OVERRIDES = ("seed=0", "seed=1", "seed=2", "seed=3", "seed=4", "seed=5")


@pytest.fixture(scope="module")
def stored(shared_database: Path) -> tuple[Path, dict[str, StoredRun], list[str]]:
    """A database with runs of all kinds; the complete ones; the fingerprints of all."""
    tracker = options(shared_database).open()
    _, curves = learned()
    points = [replace(learned(override)[0], studies=studies) for override, studies in zip(
        OVERRIDES, ((), ("a",), ("a", "b_c"), ("a%",), (), ()), strict=True
    )]  # fmt: skip
    runs = {point.fingerprint: tracker.record(point, curves) for point in points}
    client = tracker._client
    client.set_terminated(runs[points[4].fingerprint].run_id, "FAILED")
    client.delete_run(runs[points[5].fingerprint].run_id)
    # The same point in another experiment is none of ours.
    options(shared_database, experiment="other").open().record(points[4], curves)
    complete = {point.fingerprint: runs[point.fingerprint] for point in points[:4]}
    return shared_database, complete, list(runs)


@pytest.mark.parametrize("way", ["one by one", "database", "pages"])
def test_all_ways_find_the_same(way: str, stored, monkeypatch: pytest.MonkeyPatch):
    database, complete, fingerprints = stored
    tracker = options(database).open()
    monkeypatch.setattr(index, "_FEW", 100 if way == "one by one" else 0)
    monkeypatch.setattr(index, "_RUNS_PER_PAGE", 2)
    uri = f"http://{database}" if way == "pages" else f"sqlite:///{database}"
    found = index.finished_runs(tracker._client, uri, tracker._points, fingerprints)
    assert found == complete
    # And nothing that was not asked for.
    some = fingerprints[1:3]
    assert set(index.finished_runs(tracker._client, uri, tracker._points, some)) == set(some)
    assert index.finished_runs(tracker._client, uri, tracker._points, []) == {}
