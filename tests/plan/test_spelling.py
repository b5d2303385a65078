"""Points that were built in Python are planned as if they had been typed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings

from rl_design_space.config.compose import Composer, shipped_config
from rl_design_space.design import DesignPoint, Direction, GoalReward, Linear, MultiStepActions, Task
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.spelling import Spelling
from tests.learning.strategies import points


@pytest.fixture(scope="module")
def planner() -> Iterator[Planner]:
    with shipped_config():
        yield Planner(Composer())


@pytest.fixture(scope="module")
def spell(planner: Planner) -> Spelling:
    return Spelling(planner.composer)


@settings(deadline=None)  # the first point composes its options
@given(point=points())
def test_the_overrides_describe_the_point(planner: Planner, spell: Spelling, point: DesignPoint):
    planned = spell(point)
    typed = planner(planned.overrides)
    assert typed.point == point
    assert (typed.fingerprint, typed.parameters, typed.name) == (planned.fingerprint, planned.parameters, planned.name)


def test_the_nearest_option_is_named(spell: Spelling):
    point = DesignPoint(
        representation=Direction(goals="all"),
        exploration=Linear(k=0.02),
        msa=MultiStepActions(lengths=(3, 5)),
        reward=GoalReward(step=0.0, sub_goal=0.0),
        task=Task(goals=2),
    )
    planned = spell(point)
    assert planned.name == (
        "representation=direction representation.goals=all exploration=linear exploration.k=0.02 msa=lengths_3_5 "
        "reward=end_reward task.goals=2"
    )
    assert spell(DesignPoint()).name == "defaults"


@dataclass(frozen=True)
class Halving:
    """ε is halved from trial to trial."""

    __version__ = 1
    mode: str = "plain, or not"

    def schedule(self, trials: int) -> np.ndarray:
        return 0.5 ** np.arange(1, trials + 1)


def test_a_component_without_an_option_is_named_by_its_class(spell: Spelling):
    planned = spell(replace(DesignPoint(), exploration=Halving()))
    assert planned.parameters["exploration"] == f"{__name__}.Halving"
    assert planned.parameters["exploration.source"] == "version 1"
    assert planned.overrides == ("exploration=tests.plan.test_spelling.Halving",)
