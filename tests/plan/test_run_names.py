"""Names of runs: what differs within a sweep, and no more."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest

from rl_design_space.plan.plan import Plan
from rl_design_space.plan.planner import Planner, plan_point
from rl_design_space.plan.run_names import RunNames
from rl_design_space.plan.study import load_study, plan_overrides, union


@dataclass(frozen=True)
class Chosen:
    """A point as far as names need it."""

    parameters: dict[str, Any]


def names_of(*points: dict[str, Any], typed: tuple[str, ...] = ()) -> list[str]:
    chosen = [Chosen({"task.periods": 500, **point}) for point in points]
    names = RunNames(chosen, typed)
    return [names.name(point.parameters) for point in chosen]


def all_names(plan: Plan) -> list[str]:
    return [planned.run_name(planned.parameters) for planned in plan]


def test_a_name_is_what_differs_and_no_more(planner: Planner):
    grid = ["representation=ad_hoc,direction", "exploration=linear", "exploration.k=0.02,0.1"]
    plan = plan_overrides([*grid, "reward=many_rewards,end_reward"], planner).named()
    assert all_names(plan)[-1] == "direction k=0.1 end"
    assert len({*all_names(plan)}) == 8


def test_what_was_typed_is_named(planner: Planner):
    typed = ["task.periods=20", "seed=3", "threads=2"]
    plan = load_study("fig2", typed, planner).plan.named(typed)
    assert all_names(plan)[0] == "ad_hoc k=0.01 seed=3 periods=20"
    assert all_names(load_study("fig2", [], planner).plan.named())[0] == "ad_hoc k=0.01"


@pytest.mark.parametrize("studies", [["table4"], ["fig3", "table4"], ["options"], ["claims"]])
def test_names_are_unique_within_a_sweep(studies: list[str], planner: Planner):
    plan = union([load_study(name, [], planner).plan for name in studies]).named()
    assert len({*all_names(plan)}) == len(plan)
    part = plan.shard(1, 2)
    assert {*all_names(part)} < {*all_names(plan)}


def test_another_number_of_periods_is_named(planner: Planner):
    planned = load_study("fig2", [], planner).plan.named()[0]
    other = planned.with_periods(20)
    assert other.run_name(other.parameters) == "ad_hoc k=0.01 periods=20"
    same = other.with_periods(planned.point.task.periods)
    assert same.run_name(same.parameters) == "ad_hoc k=0.01"


def test_a_single_point_is_named_after_what_was_typed():
    planned = plan_point(["representation=direction", "exploration.epsilon=0.5"])
    assert planned.run_name(planned.parameters) == "direction epsilon=0.5"
    default = plan_point([])
    assert default.run_name(default.parameters) == "defaults"


def test_what_was_typed_inside_of_a_component_is_named(planner: Planner):
    texts = ["direction", "{_target_: rl_design_space.design.Direction, goals: all}"]
    without = ["representation=without", "representation.leave_out=[goal1]"]
    points = [planner([*without, f"representation.of={text}"]) for text in texts]
    assert [planned.run_name(planned.parameters) for planned in points] == [
        "without of=Direction leave_out=['goal1']",
        "without of=Direction goals=all leave_out=['goal1']",
    ]


def test_equal_words_are_told_apart():
    first, second = names_of({"world": "end", "reward": "end"}, {"world": "torus", "reward": "end_reward"})
    assert (first, second) == ("world=end reward=end", "torus end_reward")
    first, second = names_of(
        {"world": "none", "msa.reward": 1, "x.reward": 1}, {"world": "a", "msa.reward": 2, "x.reward": 2}
    )
    assert (first, second) == ("world=none msa.reward=1 x.reward=1", "a msa.reward=2 x.reward=2")


def test_of_many_choices_the_unusual_values_are_named():
    usual = {f"learner.c{number}": 0 for number in range(7)}
    changed = [{**usual, name: 1} for name in usual]
    names = names_of(usual, *changed, typed=("task.periods",))
    assert names[:2] == ["periods=500", "periods=500 c0=1"]
    assert len({*names}) == 8
    assert names_of(usual, *changed)[0] == "usual choices"
