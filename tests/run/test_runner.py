"""Running a plan: learn what is missing, once; tell and count what fails; end the summary whatever happens."""

from __future__ import annotations

from dataclasses import replace

import pytest
from omegaconf import OmegaConf

from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.plan.plan import Plan
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import plan_study
from rl_design_space.run import runner as run
from rl_design_space.run.executor import LocalExecutor
from rl_design_space.run.runner import Outcome, missing, run_point, run_sweep
from rl_design_space.tracking.tracker import NullTracker, StoredRun
from tests.run.trackers import Memory, MemoryTracker

TINY = {"task.periods": 2, "task.trials": 3}


@pytest.fixture
def study(planner: Planner):
    """A study called `mine` with a tiny point for each of these sizes."""

    def make(*sizes: int, name: str = "mine") -> Plan:
        blocks = {"a": {**TINY, "world.size": ",".join(map(str, sizes))}}
        return plan_study(name, OmegaConf.create({"study": {"blocks": blocks}}), (), planner)

    return make


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody waits long for others."""
    monkeypatch.setattr("rl_design_space.run.executor._MOMENT", 0.01)
    monkeypatch.setattr(run, "_PATIENCE", 0.01)


def swept(plan: Plan, tracker: MemoryTracker, threads: int = 1, **options: object) -> tuple[Outcome, Memory]:
    memory = Memory()
    outcome = run_sweep(plan, tracker, LocalExecutor(threads), memory, **options)
    assert tracker.locked == set()
    return outcome, memory


def name_of(size: int) -> str:
    return f"task.periods=2 task.trials=3 world.size={size}"


def counts(already: int = 0, done: int = 0, elsewhere: int = 0, failed: int = 0, left: int = 0) -> dict[str, int]:
    return {"already": already, "done": done, "elsewhere": elsewhere, "failed": failed, "left": left}


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_every_point_is_learned_recorded_and_reported(study, threads: int):
    plan, tracker = study(4, 5, 6), MemoryTracker()
    outcome, memory = swept(plan, tracker, threads, command="the command")
    assert outcome.counts == counts(done=3)
    assert set(memory.results) == set(memory.started_points) == {name_of(4), name_of(5), name_of(6)}
    for planned in plan:
        stored, result = tracker.runs[planned.fingerprint], memory.results[planned.name]
        expected = simulate(planned.point)
        assert isinstance(result, LearningCurves)
        assert (result.steps == expected.steps).all()
        assert stored.scalars["total_steps"] == expected.total_steps.mean()
        assert stored.studies == {"mine"}
    assert outcome.moves == sum(memory.results[planned.name].steps.sum() for planned in plan)
    (summary,) = tracker.sweeps
    assert (summary.name, summary.command, summary.status) == ("mine", "the command", "FINISHED")
    assert summary.counts == outcome.counts
    assert summary.failures == {}
    assert summary.verdict == "3 learned now"
    assert summary.stored == tracker.runs
    assert {"learning", "recording", "run"} <= set(outcome.seconds)


def test_the_longest_points_come_first(study):
    _, memory = swept(study(4, 12, 8), MemoryTracker())
    assert memory.started_points == [name_of(12), name_of(8), name_of(4)]


def test_what_is_stored_is_not_learned_again(study):
    tracker = MemoryTracker()
    swept(study(4, 6), tracker)
    outcome, memory = swept(study(4, 5, 6), tracker)
    assert outcome.counts == counts(already=2, done=1)
    assert memory.started_points == list(memory.results) == [name_of(5)]
    assert tracker.sweeps[-1].counts == outcome.counts


def test_what_is_stored_is_found_by_every_study_that_holds_it(study):
    tracker = MemoryTracker()
    swept(study(4, 5), tracker)
    swept(study(5, 6, name="yours"), tracker)
    # Nothing is missing here, which is another path through the code.
    swept(study(6, name="ours"), tracker)
    found = {planned.name: tracker.runs[planned.fingerprint].studies for planned in study(4, 5, 6)}
    assert found == {name_of(4): {"mine"}, name_of(5): {"mine", "yours"}, name_of(6): {"yours", "ours"}}


def test_nothing_missing_leaves_no_summary(study):
    tracker = MemoryTracker()
    swept(study(4), tracker)
    outcome, memory = swept(study(4), tracker)
    assert outcome.counts == counts(already=1)
    assert memory.results == {}
    assert len(tracker.sweeps) == 1


def test_a_sweep_need_not_have_a_summary(study):
    tracker = MemoryTracker()
    outcome, _ = swept(study(4), tracker, summarised=False)
    assert outcome.counts == counts(done=1)
    assert tracker.sweeps == []


def test_a_failing_point_does_not_stop_the_others(study):
    error = RuntimeError("the disk\nis full")
    plan, tracker = study(4, 5, 6), MemoryTracker(errors={name_of(5): error})
    outcome, memory = swept(plan, tracker)
    assert outcome.counts == counts(done=2, failed=1)
    assert memory.results[name_of(5)] is error
    ((fingerprint, told),) = outcome.failed.items()
    assert fingerprint == plan[1].fingerprint
    # One line, with the place where it was raised.
    assert told.startswith("RuntimeError: the disk is full (")
    assert "trackers.py:" in told
    assert set(tracker.runs) == {plan[0].fingerprint, plan[2].fingerprint}
    (summary,) = tracker.sweeps
    assert (summary.status, summary.counts) == ("FAILED", outcome.counts)
    assert summary.failures == {plan[1].command: told}


def test_a_sweep_may_stop_at_the_first_failure(study):
    plan = study(*range(4, 30))
    tracker = MemoryTracker(errors={name_of(29): OSError("full")})
    outcome, _ = swept(plan, tracker, on_error="stop")
    assert outcome.counts["failed"] == 1
    assert outcome.counts["left"] > 0
    assert tracker.sweeps[0].status == "FAILED"
    # What had been learned by then is not lost, and the next run does the rest.
    tracker.errors = {}
    again, _ = swept(plan, tracker)
    assert again.counts["already"] == outcome.counts["done"]
    assert len(tracker.runs) == len(plan)


def test_a_failed_point_is_tried_again_by_the_next_run(study):
    tracker = MemoryTracker(errors={name_of(5): OSError()})
    swept(study(4, 5), tracker)
    tracker.errors = {}
    outcome, _ = swept(study(4, 5), tracker)
    assert outcome.counts == counts(already=1, done=1)
    assert [summary.status for summary in tracker.sweeps] == ["FAILED", "FINISHED"]


@pytest.mark.parametrize("where", ["__init__", "_work"])
def test_a_failure_in_learning_counts_as_one_in_recording(study, where: str, monkeypatch: pytest.MonkeyPatch):
    def fail(*_: object) -> None:
        raise ArithmeticError("no luck")

    monkeypatch.setattr(f"rl_design_space.learning.simulation.Learning.{where}", fail)
    outcome, memory = swept(study(4, 5), MemoryTracker(), threads=2)
    assert outcome.counts == counts(failed=2)
    assert [type(result) for result in memory.results.values()] == [ArithmeticError] * 2


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, SystemExit])
def test_an_interruption_ends_the_summary_and_keeps_what_was_done(study, interruption: type[BaseException]):
    plan, tracker = study(4, 5, 6), MemoryTracker(errors={name_of(5): interruption()})
    with pytest.raises(interruption):
        run_sweep(plan, tracker, LocalExecutor(1), Memory())
    assert plan[1].fingerprint not in tracker.runs
    assert plan[2].fingerprint in tracker.runs  # the largest comes first
    (summary,) = tracker.sweeps
    assert summary.status == "KILLED"
    assert summary.counts["done"] == len(tracker.runs)
    # And the next run goes on from there.
    tracker.errors, tracker.locked = {}, set()
    outcome, _ = swept(plan, tracker)
    assert outcome.counts == counts(already=summary.counts["done"], done=3 - summary.counts["done"])


def test_a_watcher_that_raises_still_ends_the_summary(study):
    class Broken(Memory):
        def ended(self, *_: object) -> None:
            raise BrokenPipeError

    tracker = MemoryTracker()
    with pytest.raises(BrokenPipeError):
        run_sweep(study(4, 5), tracker, LocalExecutor(1), Broken())
    assert [summary.status for summary in tracker.sweeps] == ["KILLED"]


def test_a_record_that_is_lost_in_the_end_is_a_failure(study):
    plan = study(4, 5)
    tracker = MemoryTracker(lost={plan[0].fingerprint: "damaged: it is not what was written"})
    outcome, _ = swept(plan, tracker)
    assert outcome.counts == counts(done=1, failed=1)
    assert outcome.failed == {plan[0].fingerprint: "its record damaged: it is not what was written"}
    assert tracker.sweeps[0].status == "FAILED"
    assert set(tracker.sweeps[0].stored) == {plan[1].fingerprint}


def test_what_the_store_has_not_taken_yet_is_told_and_no_failure(study):
    outcome, _ = swept(study(4), MemoryTracker(pending=2))
    assert (outcome.delivery.pending, outcome.delivery.reason) == (2, "the store is away")
    assert outcome.counts == counts(done=1)


# Others at the same store.


def test_a_point_that_another_process_records_meanwhile_is_not_learned(study):
    plan = study(4, 5, 6)
    theirs = plan[1].fingerprint
    tracker = MemoryTracker(busy={theirs: 3}, records_of_others={theirs})
    outcome, memory = swept(plan, tracker)
    assert outcome.counts == counts(done=2, elsewhere=1)
    assert name_of(5) not in memory.started_points
    assert isinstance(memory.results[name_of(5)], StoredRun)
    # It belongs to this study, too.
    assert tracker.runs[theirs].studies == {"mine"}


def test_a_point_that_another_process_gives_up_is_learned_after_all(study):
    plan = study(4, 5, 6)
    outcome, memory = swept(plan, MemoryTracker(busy={plan[2].fingerprint: 3}))
    assert outcome.counts == counts(done=3)
    # Last, although it is the longest.
    assert memory.started_points[-1] == name_of(6)


@pytest.mark.parametrize("recorded", [True, False])
def test_a_single_point_waits_for_who_is_at_it(study, recorded: bool):
    (planned,), waited = study(4), []
    theirs = {planned.fingerprint}
    tracker = MemoryTracker(busy=dict.fromkeys(theirs, 3), records_of_others=theirs if recorded else set())
    stored, learned = run_point(planned, tracker, 1, lambda: waited.append("once"))
    assert learned is not recorded
    assert waited == ["once"]
    assert stored.run_id == "run 0"
    assert tracker.locked == set()


def test_a_single_point_is_learned_once(study):
    (planned,), tracker = study(4), MemoryTracker()
    first, learned = run_point(planned, tracker, 1)
    assert learned
    again, learned = run_point(replace(planned, studies=("yours",)), tracker, 1)
    assert not learned
    assert again.run_id == first.run_id
    assert again.scalars == first.scalars
    assert tracker.runs[planned.fingerprint].studies == {"mine", "yours"}
    assert tracker.sweeps == []


def test_without_tracking_everything_is_learned_every_time(study):
    for _ in range(2):
        outcome = run_sweep(study(4, 5), NullTracker(), LocalExecutor(1), Memory())
        assert outcome.counts == counts(done=2)


def test_what_is_missing_is_known_before_anything_runs(study):
    plan, tracker = study(4, 6, 5), MemoryTracker()
    tracker.runs[plan[1].fingerprint] = StoredRun("run 0")
    found = missing(plan, tracker)
    assert [planned.name for planned in found.points] == [name_of(5), name_of(4)]
    assert set(found.stored) == {plan[1].fingerprint}
