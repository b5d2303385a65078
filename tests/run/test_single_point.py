"""Running a single point: wait for its lock, return its record, or learn and record it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rl_design_space import learning
from rl_design_space.design import DesignPoint, Task, Torus
from rl_design_space.learning import LearningCurves
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.run.outcome import PointFailedError
from rl_design_space.run.single_point import run_point
from tests.run.trackers import MemoryTracker

PLANNED = PlannedPoint.of(DesignPoint(world=Torus(size=4), task=Task(periods=2, trials=3)), {}, ("size",), ("mine",))


@pytest.mark.parametrize("recorded", [True, False])
def test_a_point_that_another_process_has_locked_is_waited_for(recorded: bool):
    waits: list[str] = []
    locked = {PLANNED.fingerprint}
    tracker = MemoryTracker(busy=dict.fromkeys(locked, 3), records_of_others=locked if recorded else set())
    run = run_point(PLANNED, tracker, 1, lambda: waits.append("once"), poll=0.01)
    assert run.is_new is not recorded
    assert waits == ["once"]
    assert run.stored.run_id == "run 0"
    assert tracker.locked == set()


def test_a_point_is_learned_once_and_added_to_later_studies():
    tracker = MemoryTracker()
    first = run_point(PLANNED, tracker, 1)
    assert first.is_new
    again = run_point(replace(PLANNED, studies=("yours",)), tracker, 1)
    assert not again.is_new
    assert again.stored.run_id == first.stored.run_id
    assert again.stored.scalars == first.stored.scalars
    assert tracker.runs[PLANNED.fingerprint].studies == {"mine", "yours"}
    assert tracker.sweeps == []


def test_the_error_of_a_component_is_one_line_with_its_place(monkeypatch: pytest.MonkeyPatch):
    def simulate(*_: object, **__: object) -> None:
        raise NameError("name 'undefined'\nis not defined")

    monkeypatch.setattr("rl_design_space.learning.simulate", simulate)
    tracker = MemoryTracker()
    with pytest.raises(PointFailedError, match=r"^NameError: name 'undefined' is not defined \(.*single_point.*\)$"):
        run_point(PLANNED, tracker, 1)
    assert tracker.locked == set()
    assert tracker.runs == {}


def test_a_point_continues_a_run_of_fewer_periods(monkeypatch: pytest.MonkeyPatch):
    tracker, begun = MemoryTracker(), []
    first = run_point(PLANNED, tracker, 1).result
    learn = learning.simulate

    def simulate(*arguments: object, **more: object) -> LearningCurves:
        begun.append(more["begun"])
        return learn(*arguments, **more)

    monkeypatch.setattr("rl_design_space.learning.simulate", simulate)
    longer = PLANNED.with_periods(5)
    found = run_point(longer, tracker, 1).result
    assert begun == [first]
    assert (found.steps == learn(longer.point).steps).all()
    assert set(tracker.runs) == {PLANNED.fingerprint, longer.fingerprint}
