"""Recorded runs of a point with another number of periods, whose periods are not learned again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rl_design_space.learning import LearningCurves
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.tracking import server
from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.found_run import FoundRun
from tests.tracking.stores import learned, tracker_at, undelivered_tracker_at

FEW, MORE = "task.periods=3", "task.periods=5"


def begun(tracker, planned: PlannedPoint) -> LearningCurves | None:
    """Return the result that a point continues."""
    beginning = tracker.beginnings([planned]).get(planned.fingerprint)
    return tracker.result(beginning, planned) if beginning else None


def test_the_longest_run_with_another_number_of_periods_is_used(database: Path):
    for overrides in (["task.periods=2"], [FEW, "seed=1"], ["task.periods=4", "seed=1"]):
        tracker_at(database).record(*learned(*overrides))
    (planned, _), (short, expected) = learned(MORE), learned(FEW)
    tracker_at(database).record(short, expected)
    tracker = tracker_at(database)
    found = begun(tracker, planned)
    np.testing.assert_array_equal(found.steps, expected.steps)
    np.testing.assert_array_equal(found.rows, expected.rows)
    assert found.seconds == pytest.approx(expected.seconds)
    assert tracker.beginnings([planned])[planned.fingerprint].periods == 3
    # With more periods than are asked for, nothing is left to learn; the point itself is none.
    fewer, same = learned("task.periods=2")[0], short
    assert {key: found.periods for key, found in tracker.beginnings([fewer, same]).items()} == {
        fewer.fingerprint: 3,
        same.fingerprint: 2,
    }
    assert tracker.beginnings([learned(MORE, "seed=2")[0], learned(MORE, "world.size=5")[0]]) == {}


def test_a_pending_record_is_continued(database: Path):
    tracker = undelivered_tracker_at(database)
    tracker.record(*learned(FEW))
    (planned, _), (_, expected) = learned(MORE), learned(FEW)
    np.testing.assert_array_equal(begun(tracker, planned).steps, expected.steps)


def test_a_record_that_is_delivered_before_it_is_read_is_continued(database: Path):
    pending, (planned, _) = undelivered_tracker_at(database), learned(MORE)
    pending.record(*learned(FEW))
    beginning = pending.beginnings([planned])[planned.fingerprint]
    assert beginning.run.run_id == ""
    assert tracker_at(database).record(*learned("seed=1"))  # delivers all
    assert pending.result(beginning, planned) is not None


def test_a_run_whose_file_is_damaged_is_not_continued(database: Path):
    tracker, (planned, _) = tracker_at(database), learned(MORE)
    for overrides in ([FEW], [FEW, "seed=1"]):
        tracker.record(*learned(*overrides))
    one, other = (
        Path(run.artifacts.removeprefix("file://")) / "periods.npz"
        for run in (tracker.finished([learned(*each)[0].fingerprint]).popitem()[1] for each in ([FEW], [FEW, "seed=1"]))
    )
    assert begun(tracker, planned) is not None
    for content in (other.read_bytes(), b"damaged"):
        one.write_bytes(content)
        assert begun(tracker, planned) is None
    one.unlink()
    assert begun(tracker, planned) is None
    assert planned.fingerprint in tracker.beginnings([planned])


def test_a_run_that_kept_its_curves_alone_is_not_continued(database: Path):
    tracker, (planned, _) = tracker_at(database, artifact="curves"), learned(MORE)
    tracker.record(*learned(FEW))
    assert begun(tracker, planned) is None


def test_a_server_is_asked_for_each_number_of_periods_once(monkeypatch: pytest.MonkeyPatch):
    recorded, asked = ["50", "500", "50", "2000"], []

    def search(client: object, experiment: str, wanted: str, per_page: int):
        asked.append(wanted)
        assert per_page == 1
        return (FoundRun("id", "", 0, 0, "", {"task.periods": n}) for n in recorded if f"!= '{n}'" not in wanted)

    monkeypatch.setattr(server, "search_runs", search)
    monkeypatch.setattr(server.ServerQueries, "_known", lambda *_: "1")
    monkeypatch.setattr(server.ServerQueries, "_client", lambda _: None)
    queries = server.ServerQueries(StoreAddress("http://localhost:1", "design points", "sweeps"))
    assert queries.period_counts() == {50, 500, 2000}
    assert len(asked) == 4
    assert asked[0] == "attributes.status = 'FINISHED' and params.`task.periods` != '0'"
