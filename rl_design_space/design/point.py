"""A design point: one value for every design choice."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING, Annotated, get_args

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.design.actions import ActionSet, SeeingActions
from rl_design_space.design.adaptive import ClosedLoop, Level, OptimisticValues, level_of
from rl_design_space.design.curriculum import Curriculum, Stages, stages_of
from rl_design_space.design.exploration import Constant, Exploration
from rl_design_space.design.identity import absent_as, full_name
from rl_design_space.design.lacking import component_of
from rl_design_space.design.learned_in_lanes import learned_in_lanes
from rl_design_space.design.learner import QLearning, TabularLearner
from rl_design_space.design.msa import MultiStepActions
from rl_design_space.design.observing import FittedRepresentation, Representation
from rl_design_space.design.representation import AdHoc
from rl_design_space.design.reward import GoalReward, PotentialReward, Reward, TransitionReward
from rl_design_space.design.task import Task
from rl_design_space.design.world import MOVES, Torus, World, cell_count

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

#: Values of a Q-matrix are numbered by uint32.
_MOST_VALUES = 2**32 - 1


@dataclass(frozen=True, kw_only=True, config=STRICT)
class DesignPoint:
    """One setting of the whole experiment; the defaults are the paper's.

        DesignPoint(representation=Direction(), exploration=Linear(k=0.02), task=Task(goals=2))

    `dataclasses.replace` returns a point that differs in some choices.

    Points are values: equal points give the same learning curves, bit for bit.

    Attributes:
        seed: source of all randomness; points of equal size and seed have the same starts and goals.
        task: how many goals to reach, and how often to try.
        world: where the agent moves.
        representation: what the agent observes of its position, the goals and its progress.
        exploration: probability of an exploratory action, by trial.
        msa: actions of several steps, beside the primitive actions or in their place.
        reward: rewards of steps and goals.
        learner: learning rule and its parameters.
        curriculum: stages of a period that differ in something and share one Q-matrix.

    Raises:
        pydantic.ValidationError: a choice is of the wrong kind, the goals or the representation do not fit the world,
            or the actions see what the representation does not show.
    """

    seed: Annotated[int, Field(ge=0, lt=2**64)] = 0
    task: Task = Task()
    world: Annotated[World, component_of(World)] = Torus()
    representation: Annotated[Representation, component_of(Representation)] = AdHoc()
    exploration: Annotated[Exploration, component_of(Exploration)] = Constant()
    msa: Annotated[ActionSet, component_of(ActionSet)] = MultiStepActions()
    reward: Annotated[Reward, component_of(Reward)] = GoalReward()
    learner: Annotated[TabularLearner, component_of(TabularLearner)] = QLearning()
    curriculum: Annotated[Curriculum, component_of(Curriculum)] = field(
        default=Stages(), metadata=absent_as(Stages(), listed=False)
    )

    @model_validator(mode="after")
    def _goals_fit_the_world(self) -> DesignPoint:
        cells = cell_count(self.world)
        if self.task.goals >= cells:
            raise ValueError(
                f"task.goals={self.task.goals}: start and goals lie on different cells, "
                f"so a world of {cells} cells has room for at most {cells - 1} goals"
            )
        # A row takes a multiple of four values.
        values = self.task.goals * cells * 4 * -(-self.msa.n_actions // 4)
        if values > _MOST_VALUES:
            raise ValueError(
                f"task.goals={self.task.goals}: with {cells} cells and these actions a period may need a Q-matrix of "
                f"{values} values; at most {_MOST_VALUES} can be learned"
            )
        if self.msa.reward == "printed" and isinstance(self.reward, (PotentialReward, TransitionReward)):
            raise ValueError(
                "msa.reward=printed: the return as printed takes the reward of the first step for that of all steps, "
                "so it cannot be used with rewards that depend on the state; use msa.reward=realised"
            )
        if isinstance(self.representation, FittedRepresentation):
            self.representation.check(self.world, self.task.goals)
        if isinstance(self.msa, SeeingActions):
            self.msa.check(self.world, self.representation, self.task.goals)
        return self

    @model_validator(mode="after")
    def _learner_and_exploration_fit(self) -> DesignPoint:
        learner, exploration = self.learner, self.exploration
        level = level_of(exploration)
        if level not in get_args(Level):
            raise ValueError(f"exploration: {full_name(type(exploration))}.level={level}: {_or(get_args(Level))}")
        if isinstance(exploration, ClosedLoop) and level != "epsilon":
            raise ValueError(f"exploration: {full_name(type(exploration))}.rule() gives ε, so its level is epsilon")
        if level != "epsilon" and learner.explore != "non_greedy":
            raise ValueError(
                f"learner.explore={learner.explore}: says what ε-greedy exploration draws from, which "
                f"exploration={full_name(type(exploration))} does not do"
            )
        if isinstance(exploration, OptimisticValues) and learner.initial_q != 0.0:
            raise ValueError(
                f"learner.initial_q={learner.initial_q}: exploration={full_name(type(exploration))} says what Q-values "
                "begin with; change its scale"
            )
        if not learned_in_lanes(self) and not (self.msa.n_actions == len(MOVES) and self.msa.repeats):
            beside = f"learner={full_name(type(learner))}"
            if isinstance(learner, QLearning):
                beside = f"learner.alpha_schedule={learner.alpha_schedule}"
                if learner.alpha_schedule == "constant":
                    beside = f"exploration={full_name(type(exploration))}"
            raise ValueError(
                f"{beside}: goes with msa=none alone. What the other actions learn from an action of several steps is "
                "defined for Q-learning with constant α and a schedule of ε (docs/decisions/0036)"
            )
        return self

    @model_validator(mode="after")
    def _stages_fit_each_other(self) -> DesignPoint:
        stages_of(self)
        return self

    if TYPE_CHECKING:

        @classmethod
        def from_overrides(cls, overrides: Sequence[str] = (), config_dir: str | Path | None = None) -> DesignPoint:
            """Compose a point from overrides; added by `rl_design_space`, because this module composes nothing."""
            ...


def _or(names: Sequence[str]) -> str:
    return f"should be {', '.join(names[:-1])} or {names[-1]}"
