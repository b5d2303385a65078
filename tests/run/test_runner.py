"""Running a plan: missing points are learned once, failures are counted, the summary run is always closed."""

from __future__ import annotations

from contextlib import nullcontext

import pytest
from omegaconf import OmegaConf

from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.plan.plan import Plan
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import plan_study
from rl_design_space.run.local_executor import LocalExecutor
from rl_design_space.run.outcome import Outcome
from rl_design_space.run.runner import missing, run_sweep
from rl_design_space.tracking.tracker import NullTracker, StoredRun
from tests.run.trackers import MemoryMonitor, MemoryTracker

TINY = {"task.periods": 2, "task.trials": 3}


@pytest.fixture
def study(planner: Planner):
    """Create a study with a tiny point for each of these sizes."""

    def make(*sizes: int, name: str = "mine") -> Plan:
        blocks = {"a": {**TINY, "world.size": ",".join(map(str, sizes))}}
        return plan_study(name, OmegaConf.create({"study": {"blocks": blocks}}), (), planner)

    return make


def swept(plan: Plan, tracker: MemoryTracker, threads: int = 1, **options: object) -> tuple[Outcome, MemoryMonitor]:
    monitor = MemoryMonitor()
    outcome = run_sweep(plan, tracker, LocalExecutor(threads, poll=0.01), monitor, **options)
    assert tracker.locked == set()
    return outcome, monitor


def name_of(size: int) -> str:
    return f"task.periods=2 task.trials=3 world.size={size}"


def counts(already: int = 0, done: int = 0, elsewhere: int = 0, failed: int = 0, left: int = 0) -> dict[str, int]:
    return {"already": already, "done": done, "elsewhere": elsewhere, "failed": failed, "left": left}


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_every_point_is_learned_recorded_and_reported(study, threads: int):
    plan, tracker = study(4, 5, 6), MemoryTracker()
    outcome, monitor = swept(plan, tracker, threads, command="the command")
    assert outcome.counts == counts(done=3)
    assert set(monitor.results) == set(monitor.started_points) == {name_of(4), name_of(5), name_of(6)}
    for planned in plan:
        stored, result = tracker.runs[planned.fingerprint], monitor.results[planned.name]
        expected = simulate(planned.point)
        assert isinstance(result, LearningCurves)
        assert (result.steps == expected.steps).all()
        assert stored.scalars["total_steps"] == expected.total_steps.mean()
        assert stored.studies == {"mine"}
    assert outcome.steps == sum(monitor.results[planned.name].steps.sum() for planned in plan)
    (summary,) = tracker.sweeps
    assert (summary.name, summary.command, summary.status) == ("mine", "the command", "FINISHED")
    assert summary.counts == outcome.counts
    assert summary.failures == {}
    assert summary.verdict == "3 learned now"
    assert summary.stored == tracker.runs
    assert {"learning", "recording", "run"} <= set(outcome.seconds)


def test_the_longest_points_come_first(study):
    _, monitor = swept(study(4, 12, 8), MemoryTracker())
    assert monitor.started_points == [name_of(12), name_of(8), name_of(4)]


def test_recorded_points_are_not_learned_again(study):
    tracker = MemoryTracker()
    swept(study(4, 6), tracker)
    outcome, monitor = swept(study(4, 5, 6), tracker)
    assert outcome.counts == counts(already=2, done=1)
    assert monitor.started_points == list(monitor.results) == [name_of(5)]
    assert tracker.sweeps[-1].counts == outcome.counts


def test_recorded_points_belong_to_every_study_that_contains_them(study):
    tracker = MemoryTracker()
    swept(study(4, 5), tracker)
    swept(study(5, 6, name="yours"), tracker)
    # No point is missing here.
    swept(study(6, name="ours"), tracker)
    found = {planned.name: tracker.runs[planned.fingerprint].studies for planned in study(4, 5, 6)}
    assert found == {name_of(4): {"mine"}, name_of(5): {"mine", "yours"}, name_of(6): {"yours", "ours"}}


def test_a_complete_plan_opens_no_summary_run(study):
    tracker = MemoryTracker()
    swept(study(4), tracker)
    outcome, monitor = swept(study(4), tracker)
    assert outcome.counts == counts(already=1)
    assert monitor.results == {}
    assert len(tracker.sweeps) == 1


def test_a_sweep_without_a_summary_run(study):
    tracker = MemoryTracker()
    outcome, _ = swept(study(4), tracker, summarised=False)
    assert outcome.counts == counts(done=1)
    assert tracker.sweeps == []


def test_a_failing_point_does_not_stop_the_others(study):
    error = RuntimeError("the disk\nis full")
    plan, tracker = study(4, 5, 6), MemoryTracker(errors={name_of(5): error})
    outcome, monitor = swept(plan, tracker)
    assert outcome.counts == counts(done=2, failed=1)
    assert monitor.results[name_of(5)] is error
    ((fingerprint, message),) = outcome.failed.items()
    assert fingerprint == plan[1].fingerprint
    # One line, with the place where it was raised.
    assert message.startswith("RuntimeError: the disk is full (")
    assert "trackers.py:" in message
    assert set(tracker.runs) == {plan[0].fingerprint, plan[2].fingerprint}
    (summary,) = tracker.sweeps
    assert (summary.status, summary.counts) == ("FAILED", outcome.counts)
    assert summary.failures == {plan[1].command: message}


def test_on_error_stop_starts_no_further_point(study):
    plan = study(*range(4, 30))
    tracker = MemoryTracker(errors={name_of(29): OSError("full")})
    outcome, _ = swept(plan, tracker, on_error="stop")
    assert outcome.counts["failed"] == 1
    assert outcome.counts["left"] > 0
    assert tracker.sweeps[0].status == "FAILED"
    # Recorded points are kept, and the next run learns the others.
    tracker.errors = {}
    again, _ = swept(plan, tracker)
    assert again.counts["already"] == outcome.counts["done"]
    assert len(tracker.runs) == len(plan)


def test_a_failed_point_is_learned_by_the_next_run(study):
    tracker = MemoryTracker(errors={name_of(5): OSError()})
    swept(study(4, 5), tracker)
    tracker.errors = {}
    outcome, _ = swept(study(4, 5), tracker)
    assert outcome.counts == counts(already=1, done=1)
    assert [summary.status for summary in tracker.sweeps] == ["FAILED", "FINISHED"]


@pytest.mark.parametrize("where", ["__init__", "_work"])
def test_a_failure_in_learning_is_counted(study, where: str, monkeypatch: pytest.MonkeyPatch):
    def fail(*_: object) -> None:
        raise ArithmeticError("no luck")

    monkeypatch.setattr(f"rl_design_space.learning.simulation.Learning.{where}", fail)
    outcome, monitor = swept(study(4, 5), MemoryTracker(), threads=2)
    assert outcome.counts == counts(failed=2)
    assert [type(result) for result in monitor.results.values()] == [ArithmeticError] * 2


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, SystemExit])
def test_an_interruption_closes_the_summary_run_and_keeps_recorded_points(study, interruption: type[BaseException]):
    plan, tracker = study(4, 5, 6), MemoryTracker(errors={name_of(5): interruption()})
    with pytest.raises(interruption):
        run_sweep(plan, tracker, LocalExecutor(1, poll=0.01), MemoryMonitor())
    assert plan[1].fingerprint not in tracker.runs
    assert plan[2].fingerprint in tracker.runs  # the largest comes first
    (summary,) = tracker.sweeps
    assert summary.status == "KILLED"
    assert summary.counts["done"] == len(tracker.runs)
    # The next run learns the others.
    tracker.errors, tracker.locked = {}, set()
    outcome, _ = swept(plan, tracker)
    assert outcome.counts == counts(already=summary.counts["done"], done=3 - summary.counts["done"])


def test_an_error_of_the_monitor_closes_the_summary_run(study):
    class Broken(MemoryMonitor):
        def point_ended(self, *_: object) -> None:
            raise BrokenPipeError

    tracker = MemoryTracker()
    with pytest.raises(BrokenPipeError):
        run_sweep(study(4, 5), tracker, LocalExecutor(1), Broken())
    assert [summary.status for summary in tracker.sweeps] == ["KILLED"]


def test_a_record_that_cannot_be_stored_is_a_failure(study):
    plan = study(4, 5)
    tracker = MemoryTracker(lost={plan[0].fingerprint: "damaged: it is not what was written"})
    outcome, _ = swept(plan, tracker)
    assert outcome.counts == counts(done=1, failed=1)
    assert outcome.failed == {plan[0].fingerprint: "its record cannot be stored: damaged: it is not what was written"}
    assert tracker.sweeps[0].status == "FAILED"
    assert set(tracker.sweeps[0].stored) == {plan[1].fingerprint}


def test_pending_records_are_counted_and_are_no_failure(study):
    outcome, _ = swept(study(4), MemoryTracker(pending=2))
    assert (outcome.delivery.pending, outcome.delivery.reason) == (2, "the store is away")
    assert outcome.counts == counts(done=1)


# Other processes with the same store.


def test_a_point_that_another_process_records_is_not_learned(study):
    plan = study(4, 5, 6)
    theirs = plan[1].fingerprint
    tracker = MemoryTracker(busy={theirs: 3}, records_of_others={theirs})
    outcome, monitor = swept(plan, tracker)
    assert outcome.counts == counts(done=2, elsewhere=1)
    assert name_of(5) not in monitor.started_points
    assert isinstance(monitor.results[name_of(5)], StoredRun)
    # It is added to this study.
    assert tracker.runs[theirs].studies == {"mine"}


def test_a_point_that_another_process_releases_is_learned(study):
    plan = study(4, 5, 6)
    outcome, monitor = swept(plan, MemoryTracker(busy={plan[2].fingerprint: 3}))
    assert outcome.counts == counts(done=3)
    assert set(monitor.waited[:-1]) == {1}
    assert monitor.waited[-1] == 0
    # It comes last, although it is the longest.
    assert monitor.started_points[-1] == name_of(6)


def test_without_tracking_every_point_is_learned_every_time(study):
    for _ in range(2):
        outcome = run_sweep(study(4, 5), NullTracker(), LocalExecutor(1, poll=0.01), MemoryMonitor())
        assert outcome.counts == counts(done=2)


@pytest.mark.parametrize("seconds", [0.1, 40.0])
def test_the_time_of_compiling_is_told_if_it_is_worth_it(study, seconds: float, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("rl_design_space.learning.compiled.compile_timer", lambda: nullcontext(lambda: seconds))
    outcome, _ = swept(study(4), MemoryTracker())
    assert ("compiling" in outcome.seconds) == (seconds > 1)
    assert outcome.seconds.get("compiling", 40.0) == 40.0


def test_missing_returns_the_points_without_a_run_the_longest_first(study):
    plan, tracker = study(4, 6, 5), MemoryTracker()
    tracker.runs[plan[1].fingerprint] = StoredRun("run 0")
    found = missing(plan, tracker)
    assert [planned.name for planned in found.points] == [name_of(5), name_of(4)]
    assert set(found.stored) == {plan[1].fingerprint}


def test_points_continue_runs_of_fewer_periods(study):
    short, tracker = study(4, 5), MemoryTracker()
    swept(short, tracker)
    longer = Plan([planned.with_periods(7) for planned in study(4, 5, 6)])
    found = missing(longer, tracker)
    assert {fingerprint: beginning.periods for fingerprint, beginning in found.begun.items()} == {
        planned.fingerprint: 2 for planned in longer[:2]
    }
    # The one that is learned from the beginning takes longest, though the grids of others are larger.
    assert found.points[0] == longer[2]
    outcome, _ = swept(longer, tracker, threads=2)
    assert outcome.counts == counts(done=3)
    learned = 0
    for planned in longer:
        expected = simulate(planned.point)
        assert (tracker.results[planned.fingerprint].steps == expected.steps).all()
        learned += expected.steps[2 if planned in longer[:2] else 0 :].sum()
    assert outcome.steps == learned
    # The runs of fewer periods stay, because they are those points.
    assert {planned.fingerprint for planned in short} < set(tracker.runs)


def test_the_same_point_with_another_number_of_periods(planner: Planner):
    planned = planner(["task.periods=3", "seed=1"], ("mine",))
    longer, other = planned.with_periods(8), planner(["seed=1", "task.periods=8"], ("mine",))
    assert longer == other
    assert (longer.name, longer.point.task.periods) == ("seed=1 task.periods=8", 8)
