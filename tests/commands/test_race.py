"""Races: which points get how many periods, what is recorded and printed, and what is refused."""

from __future__ import annotations

import csv
import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rl_design_space.analysis.best import best_means
from rl_design_space.analysis.race import looks
from rl_design_space.commands.race import race_looks
from rl_design_space.commands.race_output import show_plan
from rl_design_space.commands.race_run import Race
from rl_design_space.commands.sweep_output import Recorded
from rl_design_space.commands.sweep_result import more_lines
from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.plan.plan import Plan
from rl_design_space.run.local_executor import LocalExecutor
from rl_design_space.run.outcome import Outcome
from rl_design_space.run.settings import Settings, settings_of
from tests.command_runner import commands_in
from tests.points import planned_point
from tests.run.trackers import MemoryTracker
from tests.tracking.stores import copy_database

SLOPES, REWARDS = (0.01, 0.1, 0.12), ("many_rewards", "end_reward")
SMALL = ("exploration=linear", "task.trials=6", "world.size=4", "task.periods=60")
RULES = {"first": 10, "growth": 2.0, "confidence": 0.95}


class Launcher:
    """A launcher that learns design points."""

    dumps = False

    def executor(self, threads: int) -> LocalExecutor:
        return LocalExecutor(threads)


@pytest.fixture(scope="module")
def plan() -> Plan:
    points = [planned_point([*SMALL, f"exploration.k={k}", f"reward={reward}"]) for k in SLOPES for reward in REWARDS]
    return Plan(points, ("mine",))


@pytest.fixture(scope="module")
def settings() -> Settings:
    return settings_of(["tracking=none"])


def raced(
    plan: Plan, settings: Settings, tracker: MemoryTracker, threads: int = 1, objective: str = "total_steps"
) -> tuple[Race, Outcome]:
    chosen = replace(settings, objective=objective)
    race = Race(plan, looks(60, 10, 2.0), 0.95, chosen, tracker, LocalExecutor(threads), "the command")
    return race, race.run()


def test_a_race_finds_the_best_set_and_records_ordinary_points(plan: Plan, settings: Settings):
    tracker = MemoryTracker()
    race, outcome = raced(plan, settings, tracker)
    full = [simulate(planned.point) for planned in plan]
    expected = best_means(np.stack([curves.total_steps for curves in full], axis=1))
    found = race.result
    assert found.best.inside.tolist() == expected.inside.tolist()
    periods = found.periods.astype(int).tolist()
    assert max(periods) == 60
    assert min(periods) == 10
    assert found.spent == sum(c.total_steps[:n].sum() for c, n in zip(full, periods, strict=True)) < found.full
    for planned, curves, count in zip(plan, full, periods, strict=True):
        # A point that was stopped is the point with so many periods.
        assert (tracker.results[planned.with_periods(count).fingerprint].steps == curves.steps[:count]).all()
    assert outcome.steps == found.spent  # nothing was learned twice
    (summary,) = tracker.sweeps
    assert (summary.status, summary.counts["done"]) == ("FINISHED", len(tracker.runs))
    assert summary.findings.best == frozenset(
        planned.fingerprint for planned, inside in zip(found.plan, found.best.inside, strict=True) if inside
    )

    again, repeated = raced(plan, settings, tracker)
    assert (repeated.done, repeated.steps, len(tracker.sweeps)) == (0, 0, 1)
    assert again.result.lines == found.lines
    assert again.result.findings == found.findings


def test_the_result_depends_neither_on_threads_nor_on_what_was_there_before(plan: Plan, settings: Settings):
    race, outcome = raced(plan, settings, MemoryTracker())
    other, _ = raced(plan, settings, MemoryTracker(), threads=3)
    assert other.result.findings == race.result.findings
    stopped = MemoryTracker(errors={plan[4].with_periods(20).name: KeyboardInterrupt()})
    with pytest.raises(KeyboardInterrupt):
        raced(Plan([*plan]), settings, stopped)
    assert stopped.sweeps[0].status == "KILLED"
    stopped.errors = {}
    resumed, rest = raced(plan, settings, stopped)
    assert resumed.result.findings == race.result.findings
    assert 0 < rest.steps < outcome.steps


def test_a_point_that_fails_is_out_of_the_race_and_the_others_go_on(plan: Plan, settings: Settings):
    tracker = MemoryTracker(errors={plan[2].with_periods(10).name: RuntimeError("no floor")})
    race, outcome = raced(plan, settings, tracker)
    assert list(outcome.failed) == [plan[2].with_periods(10).fingerprint]
    assert len(race.result.plan) == len(plan) - 1
    took, failed, _ = race.result.lines
    assert took.startswith(f"race: {len(plan)} designs began with 10 periods")
    assert failed == "1 of them failed and are left out, although one may be the best"
    (summary,) = tracker.sweeps
    assert summary.status == "FAILED"
    assert list(summary.failures) == [plan[2].with_periods(10).command]
    tracker = MemoryTracker(errors=dict(tracker.errors))
    race, outcome = raced(plan, replace(settings, on_error="stop"), tracker)
    assert race.result is None  # how many points are left depends on how many were being learned
    assert list(outcome.failed) == [plan[2].with_periods(10).fingerprint]


def test_the_largest_value_can_be_the_best_one(plan: Plan, settings: Settings):
    race, _ = raced(plan, settings, MemoryTracker(), objective="near_share=2")
    found = race.result
    assert found.values[found.best.leader] == found.values[found.periods == found.periods.max()].max()
    assert found.listed[0].startswith(f"★ {found.values[found.best.leader]:.4g}")


@pytest.mark.parametrize(
    ("overrides", "changed", "rules", "message"),
    [
        (["seed=0", "seed=1"], {}, {}, "seed=0,1: a race compares designs over the periods of one seed"),
        (["task.periods=30", "task.periods=60"], {}, {}, "task.periods=30,60: a race compares .* the largest of them"),
        (["task.precision=0.1"], {}, {}, "task.precision=0.1: a race decides itself how many periods"),
        (["seed=0"], {"shard": (1, 4)}, {}, "shard=1/4: a race compares all its points"),
        (["seed=0"], {}, {"first": 2}, "hydra.sweeper.first=2: should be a whole number of periods, 5 or more"),
        (["seed=0"], {}, {"growth": 1}, "hydra.sweeper.growth=1: should be a factor above 1, 10 at most"),
        (["seed=0"], {}, {"confidence": "95 %"}, "hydra.sweeper.confidence=95 %: should be a probability"),
        (["task.trials=6"], {"objective": "steps_after=6"}, {}, "objective: steps_after=6: there are 6 trials; should"),
        (["task.trials=6"], {"objective": "solved,stage=2"}, {}, "objective: stage=2: should be from 1 to 1"),
        (["seed=0"], {"objective": "trials_to_optimum"}, {}, "objective=trials_to_optimum: a race compares means"),
    ],
)
def test_what_cannot_be_raced_is_refused(overrides, changed, rules, message: str, settings: Settings):
    plan = Plan([planned_point([*SMALL, override]) for override in overrides])
    with pytest.raises(ConfigError, match=message):
        race_looks(plan, replace(settings, **changed), Launcher(), {**RULES, **rules})


def test_with_no_more_periods_than_the_first_look_all_points_get_them(
    plan: Plan, settings: Settings, capsys: pytest.CaptureFixture[str]
):
    few = Plan([planned.with_periods(10) for planned in plan])
    (look,) = race_looks(few, settings, Launcher(), {**RULES, "first": 20})
    assert look.periods == 10
    race = Race(few, [look], 0.95, settings, MemoryTracker(), LocalExecutor(1), "the command")
    race.run()
    taken, _ = race.result.lines
    said = "race: task.periods=10 is not above hydra.sweeper.first, so none of 6 designs stopped early;"
    assert taken.startswith(said)
    assert "go on" not in capsys.readouterr().out
    show_plan(few, few, [look], settings, [Recorded(changed={"representation=mine": 6}), Recorded()])
    shown = capsys.readouterr().out
    assert "compared after 10 periods; none stops early, as task.periods is not above" in shown
    assert "- 6 run again, because their runs have other code of representation=mine" in shown


def test_an_objective_of_a_stage_is_raced_where_all_points_have_it(settings: Settings):
    staged = planned_point([*SMALL, "curriculum=new_goals", "curriculum.layouts=2"])
    chosen = replace(settings, objective="steps_after=8,stage=2")
    with pytest.raises(ConfigError, match="objective: steps_after=8: there are 6 trials"):
        race_looks(Plan([staged]), chosen, Launcher(), RULES)
    assert race_looks(Plan([staged]), replace(settings, objective="steps_after=3,stage=2"), Launcher(), RULES)


def test_commands_for_more_have_the_objective(plan: Plan):
    best, importance = more_lines(plan, ["outputs=x"], "steps_after=3")
    assert best == "more: rl-design-report best --study=mine --value steps_after=3 outputs=x"
    assert importance == "more: rl-design-report importance --study=mine --scale steps_after=3 outputs=x"
    assert more_lines(plan, [])[0] == "more: rl-design-report best --study=mine"


@pytest.mark.parametrize("objective", ["total_steps,statistic=median", "trials_to_optimum", "total_steps_sem"])
def test_only_means_over_periods_are_raced(objective: str, plan: Plan, settings: Settings):
    with pytest.raises(ConfigError, match=rf"objective={objective}: a race compares means over periods"):
        raced(plan, settings, MemoryTracker(), objective=objective)


def test_a_race_on_the_command_line(tmp_path: Path, empty_database: Path):
    command = commands_in(tmp_path)
    copy_database(empty_database, tmp_path / "out" / "mlflow.db")
    words = [
        "rl-design-space", "-m", "hydra/sweeper=race", "hydra.sweeper.first=10", "hydra.sweeper.growth=2",
        "exploration=linear", "exploration.k=0.01,0.1,0.12", "reward=many_rewards,end_reward", "task.trials=6",
        "world.size=4", "task.periods=60", "threads=1",
    ]  # fmt: skip
    planned = command(*words, "plan=true", outputs="out").stdout
    assert "compared after 10, 20, 40, 60 periods; those that are worse beyond doubt stop" in planned
    assert "at least 10 periods of each point: 0 recorded already, 6 to run: about" in planned
    assert "at most 60 periods of each point: 0 recorded already, 6 to run: about" in planned
    lines = command(*words, outputs="out").stdout.splitlines()
    (taken,) = [line for line in lines if line.startswith("race: 6 designs began with 10 periods")]
    assert "of the full sweep" in taken
    best = [line for line in lines if line.startswith("★")]
    assert best
    assert "exploration.k=" in best[0]
    assert any(line.startswith("more: rl-design-report best") for line in lines)
    repeated = command(*words, outputs="out").stdout.splitlines()
    assert ", 0 learned now, " in repeated[-1]
    assert [line for line in repeated if line.startswith(("race:", "★"))] == [taken, *best]
    with closing(sqlite3.connect(tmp_path / "out" / "mlflow.db")) as database:
        ((note, place),) = database.execute(
            "select t.value, r.artifact_uri from runs r join tags t on t.run_uuid = r.run_uuid and "
            "t.key = 'mlflow.note.content' join metrics m on m.run_uuid = r.run_uuid and m.key = 'race/share_of_steps'"
        ).fetchall()
    assert taken in note
    assert "★" in note
    with (Path(place.removeprefix("file://")) / "race.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["in_best_set"] for row in rows].count("True") == len(best)
    assert {row["task.periods"] for row in rows} <= {"10", "20", "40", "60"}
