"""Running a plan: learn what is missing, once; tell and count what fails; end the summary whatever happens."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from omegaconf import OmegaConf

from rl_design_space.learning import simulate
from rl_design_space.sweep import run
from rl_design_space.sweep.compose import Composer
from rl_design_space.sweep.plan import PlannedPoint
from rl_design_space.sweep.run import Outcome, run_point, run_sweep
from rl_design_space.sweep.study import Study, plan_study
from rl_design_space.tracking.tracker import NullTracker, StoredRun
from tests.sweep.trackers import MemoryTracker

TINY = {"task.periods": 2, "task.trials": 3}
Reports = list[tuple[str, StoredRun | Exception]]


@pytest.fixture
def study(composer: Composer):
    """A study called `mine` with a tiny point for each of these sizes."""

    def make(*sizes: int, name: str = "mine") -> Study:
        config = OmegaConf.create({"study": {"blocks": {"a": {**TINY, "world.size": ",".join(map(str, sizes))}}}})
        return Study(name, (), config, plan_study(name, config, (), composer))

    return make


def swept(study: Study, tracker: MemoryTracker) -> tuple[Outcome, Reports]:
    reports: Reports = []
    outcome = run_sweep(study, tracker, 1, lambda planned, result: reports.append((planned.name, result)))
    return outcome, reports


def name_of(size: int) -> str:
    return f"task.periods=2 task.trials=3 world.size={size}"


def test_every_point_is_learned_recorded_and_reported(study):
    plan, tracker = study(4, 5), MemoryTracker()
    outcome, reports = swept(plan, tracker)
    assert outcome.counts == {"already": 0, "done": 2, "failed": 0}
    assert [name for name, _ in reports] == [name_of(4), name_of(5)]
    assert [tracker.runs[planned.fingerprint] for planned in plan.plan] == [result for _, result in reports]
    for planned in plan.plan:
        assert tracker.runs[planned.fingerprint].scalars["total_steps"] == simulate(planned.point).total_steps.mean()
        assert tracker.runs[planned.fingerprint].studies == {"mine"}
    (summary,) = tracker.sweeps
    assert (summary.study, summary.status, summary.counts) == ("mine", "FINISHED", outcome.counts)
    assert summary.failures == {}


def test_what_is_stored_is_not_learned_again(study, monkeypatch: pytest.MonkeyPatch):
    tracker = MemoryTracker()
    swept(study(4, 6), tracker)
    learned: list[PlannedPoint] = []
    learn = run._learn
    monkeypatch.setattr(run, "_learn", lambda planned, *rest: learned.append(planned) or learn(planned, *rest))
    outcome, reports = swept(study(4, 5, 6), tracker)
    assert outcome.counts == {"already": 2, "done": 1, "failed": 0}
    assert [planned.name for planned in learned] == [name for name, _ in reports] == [name_of(5)]
    assert tracker.sweeps[-1].counts == outcome.counts


def test_what_is_stored_is_found_by_every_study_that_holds_it(study):
    tracker = MemoryTracker()
    swept(study(4, 5), tracker)
    swept(study(5, 6, name="yours"), tracker)
    # Nothing is missing here, which is another path through the code.
    swept(study(6, name="ours"), tracker)
    found = {planned.name: tracker.runs[planned.fingerprint].studies for planned in study(4, 5, 6).plan}
    assert found == {name_of(4): {"mine"}, name_of(5): {"mine", "yours"}, name_of(6): {"yours", "ours"}}


def test_nothing_missing_leaves_no_summary(study):
    tracker = MemoryTracker()
    swept(study(4), tracker)
    outcome, reports = swept(study(4), tracker)
    assert outcome.counts == {"already": 1, "done": 0, "failed": 0}
    assert reports == []
    assert len(tracker.sweeps) == 1


def test_a_failing_point_does_not_stop_the_others(study):
    error = RuntimeError("the disk is full")
    plan, tracker = study(4, 5, 6), MemoryTracker(errors={name_of(5): error})
    outcome, reports = swept(plan, tracker)
    assert outcome.counts == {"already": 0, "done": 2, "failed": 1}
    assert outcome.failed == {plan.plan[1].fingerprint: error}
    # Reported when it happens, between its neighbours.
    assert [name for name, _ in reports] == [name_of(4), name_of(5), name_of(6)]
    assert reports[1][1] is error
    assert set(tracker.runs) == {plan.plan[0].fingerprint, plan.plan[2].fingerprint}
    (summary,) = tracker.sweeps
    assert (summary.status, summary.counts) == ("FAILED", outcome.counts)
    assert summary.failures == {plan.plan[1].command: "RuntimeError('the disk is full')"}


def test_a_failed_point_is_tried_again_by_the_next_run(study):
    tracker = MemoryTracker(errors={name_of(5): OSError()})
    swept(study(4, 5), tracker)
    tracker.errors = {}
    outcome, _ = swept(study(4, 5), tracker)
    assert outcome.counts == {"already": 1, "done": 1, "failed": 0}
    assert [summary.status for summary in tracker.sweeps] == ["FAILED", "FINISHED"]


def test_a_failure_in_learning_counts_as_one_in_recording(study, monkeypatch: pytest.MonkeyPatch):
    def fail(*_: object) -> None:
        raise ArithmeticError("no luck")

    monkeypatch.setattr("rl_design_space.learning.simulate", fail, raising=False)
    outcome, reports = swept(study(4, 5), MemoryTracker())
    assert outcome.counts == {"already": 0, "done": 0, "failed": 2}
    assert all(isinstance(result, ArithmeticError) for _, result in reports)


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, SystemExit])
def test_an_interruption_ends_the_summary_and_keeps_what_was_done(study, interruption: type[BaseException]):
    plan, tracker = study(4, 5, 6), MemoryTracker(errors={name_of(5): interruption()})
    with pytest.raises(interruption):
        swept(plan, tracker)
    assert set(tracker.runs) == {plan.plan[0].fingerprint}
    (summary,) = tracker.sweeps
    assert (summary.status, summary.counts) == ("KILLED", {"already": 0, "done": 1, "failed": 0})
    # And the next run goes on from there.
    tracker.errors = {}
    outcome, _ = swept(plan, tracker)
    assert outcome.counts == {"already": 1, "done": 2, "failed": 0}


def test_a_report_that_raises_still_ends_the_summary(study):
    tracker = MemoryTracker()

    def broken_pipe(*_: object) -> None:
        raise BrokenPipeError

    with pytest.raises(BrokenPipeError):
        run_sweep(study(4, 5), tracker, 1, broken_pipe)
    assert [summary.status for summary in tracker.sweeps] == ["KILLED"]


def test_a_single_point_is_learned_once(study):
    (planned,), tracker = study(4).plan, MemoryTracker()
    first, learned = run_point(planned, tracker, 1)
    assert learned
    again, learned = run_point(replace(planned, studies=("yours",)), tracker, 1)
    assert not learned
    assert again.run_id == first.run_id
    assert tracker.runs[planned.fingerprint].studies == {"mine", "yours"}
    assert tracker.sweeps == []


def test_without_tracking_everything_is_learned_every_time(study):
    tracker = NullTracker()
    for _ in range(2):
        outcome = run_sweep(study(4, 5), tracker, 1, lambda planned, result: None)
        assert outcome.counts == {"already": 0, "done": 2, "failed": 0}
    scalars = next(iter(outcome.done.values())).scalars
    assert np.isfinite(list(scalars.values())).all()
