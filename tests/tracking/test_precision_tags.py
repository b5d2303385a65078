"""The result of a point that asks for a precision: its run is that of a number of periods, found by both."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from rl_design_space.learning import simulate
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.tracking import server
from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.found_run import FoundRun
from rl_design_space.tracking.record import params
from rl_design_space.tracking.tracker import Enough
from tests.points import planned_point
from tests.tracking.stores import TINY, learned, runs, tracker_at, undelivered_tracker_at

ASKING = (*TINY, "task.precision=0.3", "task.periods_at_most=40")


@pytest.fixture(scope="module")
def asking() -> PlannedPoint:
    return planned_point(ASKING)


@pytest.fixture(scope="module")
def curves(asking: PlannedPoint):
    return simulate(asking.point, threads=1)


def test_the_run_is_that_of_the_number_of_periods(asking: PlannedPoint, curves, tracker, client):
    fixed = asking.with_periods(len(curves.steps))
    tracker.lock(asking.fingerprint)
    stored = tracker.record(replace(asking, studies=("mine",)), curves)
    assert stored.enough == Enough(len(curves.steps), True)
    assert tracker.recorded_since(asking.fingerprint) is not None
    found = tracker.finished([asking.fingerprint, fixed.fingerprint])
    assert found[asking.fingerprint] == replace(found[fixed.fingerprint], enough=stored.enough)
    assert found[fixed.fingerprint].enough is None
    (run,) = runs(client)
    assert run.data.params == params(fixed.parameters)
    assert run.data.tags["fingerprint"] == fixed.fingerprint
    assert "3.00" not in run.data.tags["precision"]
    assert run.data.tags["precision"].startswith("total_steps to ± 30.00% at 95 %, at most 40 periods: reached, ± ")
    assert 0 < run.data.metrics["precision"] <= 0.3
    assert run.info.run_name == "size=4 trials=4 periods=" + str(len(curves.steps))
    # The run joins studies by both.
    tracker.add_studies({asking.fingerprint: found[asking.fingerprint]}, {asking.fingerprint: ("yours",)})
    assert tracker.finished([fixed.fingerprint])[fixed.fingerprint].studies == {"mine", "yours"}


@pytest.mark.parametrize("directly", [True, False], ids=["directly", "by MLflow's client"])
def test_two_points_may_need_the_same_number_of_periods(
    directly: bool, asking: PlannedPoint, curves, tracker, client, monkeypatch: pytest.MonkeyPatch
):
    if not directly:
        monkeypatch.setattr("rl_design_space.tracking.database_tables.REVISIONS", frozenset())
    periods = len(curves.steps)
    fixed, _ = learned(f"task.periods={periods}")
    tracker.record(fixed, curves)
    also = planned_point([*ASKING, "task.periods_at_most=41"])
    for planned in (asking, also):
        tracker.record(planned, curves)
    found = tracker.finished([asking.fingerprint, also.fingerprint, fixed.fingerprint])
    assert len({run.run_id for run in found.values()}) == 1
    assert len(found) == 3
    finished = [run for run in runs(client) if run.info.status == "FINISHED"]
    assert len(finished) == 1
    stored = {planned.fingerprint: found[planned.fingerprint] for planned in (asking, also)}
    tracker.add_studies(stored, {also.fingerprint: ("mine",)})
    assert tracker.finished([asking.fingerprint])[asking.fingerprint].studies == {"mine"}


def test_points_of_one_batch_may_need_the_same_number_of_periods(asking: PlannedPoint, curves, database: Path, client):
    pending, also = undelivered_tracker_at(database), planned_point([*ASKING, "task.periods_at_most=41"])
    for planned in (asking, also):
        pending.record(planned, curves)
    assert pending.finished([also.fingerprint])[also.fingerprint].enough == Enough(len(curves.steps), True)
    tracker = tracker_at(database)
    tracker.record(*learned("seed=1"))  # delivers all
    assert len(runs(client)) == 2
    many = [asking.fingerprint, also.fingerprint, *(str(number) for number in range(30))]
    assert set(tracker.finished(many)) == {asking.fingerprint, also.fingerprint}


def test_a_precision_that_is_not_reached(tracker):
    planned = planned_point([*TINY, "task.precision=0.001", "task.periods_at_most=5"])
    tracker.record(planned, simulate(planned.point, threads=1))
    assert tracker.finished([planned.fingerprint])[planned.fingerprint].enough == Enough(5, False)


def test_a_server_is_asked_for_both(monkeypatch: pytest.MonkeyPatch):
    tags = {"fingerprint": "ab", "precision": "in words", "precision.cd": "40, not reached", "study.mine": "true"}
    run, asked = FoundRun("id", "", 0, 0, "uri", {}, {"total_steps": 3.0}, tags), []

    def search(client: object, experiment: str, wanted: str, per_page: int = 0):
        asked.append(wanted)
        return iter([run] if "'ab'" in wanted or "`precision.cd` LIKE '%'" in wanted else [])

    monkeypatch.setattr(server, "search_runs", search)
    monkeypatch.setattr(server, "search_many", search)
    monkeypatch.setattr(server.ServerQueries, "_known", lambda *_: "1")
    monkeypatch.setattr(server.ServerQueries, "_client", lambda _: None)
    queries = server.ServerQueries(StoreAddress("http://localhost:1", "design points", "sweeps"))
    found = queries.finished(["ab", "cd", "ef"])
    assert {key: each.enough for key, each in found.items()} == {"ab": None, "cd": Enough(40, False)}
    assert {each.run_id for each in found.values()} == {"id"}
    assert len(asked) == 5
