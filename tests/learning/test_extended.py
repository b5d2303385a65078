"""More periods of a point: the first ones are not learned again, and the result is that of all at once, bit for bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl_design_space.design import (
    AdHoc,
    DesignPoint,
    Direct,
    Direction,
    Distance,
    Linear,
    MultiStepActions,
    Task,
    Torus,
    Walled,
)
from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.learning.simulation import Learning
from tests.learning import strategies

SMALL = DesignPoint(seed=7, task=Task(goals=2, trials=12, periods=31), world=Torus(size=6), exploration=Linear(k=0.05))
MSA = MultiStepActions(lengths=(3,), propagation="all_shorter", sub_goal="stop")


def with_periods(point: DesignPoint, periods: int) -> DesignPoint:
    return replace(point, task=replace(point.task, periods=periods))


def assert_same(one: LearningCurves, other: LearningCurves) -> None:
    assert one.point == other.point
    for name in ("steps", "success", "optimum", "rows", "epsilon"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), strict=True)


@pytest.mark.parametrize("msa", [MultiStepActions(), MSA], ids=["primitive", "multi-step"])
@pytest.mark.parametrize("representation", [AdHoc(), Direct(), Distance(), Direction()], ids=lambda each: type(each))
def test_periods_learned_in_two_parts_are_those_learned_at_once(representation: object, msa: MultiStepActions):
    point = replace(SMALL, representation=representation, msa=msa)
    whole = simulate(point, threads=1)
    for first in (1, 25):
        begun = simulate(with_periods(point, first), threads=2)
        assert_same(begun, whole.first(first))
        assert_same(simulate(point, threads=2, begun=begun), whole)


@settings(max_examples=10, deadline=None)
@given(strategies.points(), st.integers(1, 4))
def test_any_point_can_be_extended(point: DesignPoint, more: int):
    begun, longer = simulate(point, threads=1), with_periods(point, point.task.periods + more)
    assert_same(simulate(longer, threads=1, begun=begun), simulate(longer, threads=1))


def test_periods_that_were_learned_are_not_learned_again(monkeypatch: pytest.MonkeyPatch):
    begun, learned = simulate(with_periods(SMALL, 20)), []
    learn = Learning._learn
    monkeypatch.setattr(
        Learning, "_learn", lambda self, codes, table, paid, first, *rest, **options: (
            learned.extend(range(first, first + len(codes))), learn(self, codes, table, paid, first, *rest, **options)
        )
    )  # fmt: skip
    simulate(SMALL, threads=1, begun=begun)
    assert learned == list(range(20, 31))


def test_seconds_add_up_and_are_estimated_where_they_are_unknown():
    begun = replace(simulate(with_periods(SMALL, 30)), seconds=100.0)
    assert 100 < simulate(SMALL, begun=begun).seconds < 110
    unknown = simulate(SMALL, begun=replace(begun, seconds=float("nan")))
    assert 0 < unknown.seconds < 31 * 10
    assert unknown.scalars()["env_steps_per_second"] > 0


def test_of_more_periods_than_are_asked_for_the_first_ones_count():
    for periods in (31, 40):
        assert_same(simulate(SMALL, begun=simulate(with_periods(SMALL, periods))), simulate(SMALL))


@pytest.mark.parametrize(
    "other",
    [
        replace(SMALL, seed=8, task=replace(SMALL.task, periods=20)),
        replace(SMALL, task=replace(SMALL.task, trials=13, periods=20)),
        replace(SMALL, world=Walled(size=6), task=replace(SMALL.task, periods=20)),
        replace(SMALL, exploration=Linear(k=0.1), task=replace(SMALL.task, periods=20)),
    ],
    ids=["seed", "trials", "world", "exploration"],
)
def test_the_result_of_another_point_is_refused(other: DesignPoint):
    result = simulate(other)
    with pytest.raises(ValueError, match="a result of another point"):
        simulate(SMALL, begun=result)
    with pytest.raises(ValueError, match="not the first periods of this point"):
        simulate(SMALL, begun=replace(result, known_point=None))


@pytest.mark.parametrize("periods", [0, 32])
def test_there_are_no_other_first_periods_than_those_learned(periods: int):
    with pytest.raises(ValueError, match=f"^periods={periods}: should be from 1 to 31$"):
        simulate(SMALL).first(periods)
