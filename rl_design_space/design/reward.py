"""Reward functions (paper, sections 2 and 3.4)."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass
from typing_extensions import Protocol, runtime_checkable

from rl_design_space._arrays import FloatArray, IntArray
from rl_design_space._strict import STRICT
from rl_design_space.design.world import World


@runtime_checkable
class Reward(Protocol):
    """Rewards of the three kinds of steps."""

    def table(self) -> FloatArray:
        """Return the rewards of a step, of reaching the due sub-goal, and of reaching the final goal, (3,) float64."""
        ...


@runtime_checkable
class PotentialReward(Reward, Protocol):
    """Rewards with potential-based shaping: a step from state s to s' earns γ·Φ(s') - Φ(s) besides.

    See Ng, Harada and Russell, "Policy invariance under reward transformations", 1999. The discount factor γ is that of
    the learner.

    The steps of a multi-step action are shaped one by one; discounted by the k steps, they add up to γ^k·Φ(s') - Φ(s).
    The state after the final goal has no potential, so no policy becomes better than one that was better before.
    """

    def potential(self, world: World, goals: IntArray) -> FloatArray:
        """Return the potential Φ of every state, (..., n_goals, cells) float64, by success counter and cell.

        Args:
            world: where the agent moves.
            goals: (..., n_goals) cell numbers.
        """
        ...


@runtime_checkable
class TransitionReward(Reward, Protocol):
    """Rewards that depend on the state and the step."""

    def by_transition(self, world: World, goals: IntArray) -> FloatArray:
        """Return what each step earns beside the reward of `table`, (..., n_goals, 4, cells) float64.

        By success counter, step and cell before the step. In a stochastic world it may have one more axis, for the
        outcomes of the step. Waiting, which some actions do, earns nothing besides.

        Args:
            world: where the agent moves.
            goals: (..., n_goals) cell numbers.
        """
        ...


@dataclass(frozen=True, kw_only=True, config=STRICT)
class GoalReward:
    """One reward for an ordinary step, one for the due sub-goal, one for the due final goal.

    The paper's three functions are *many rewards* (-0.1, 1, 10), *each success* (0, 1, 10) and *end reward*
    (0, 0, 10). The reward of a goal that is not due is `learner.out_of_order`.

    Attributes:
        step: reward of an ordinary step.
        sub_goal: reward of a step onto the due sub-goal.
        final_goal: reward of a step onto the due final goal.
    """

    step: float = -0.1
    sub_goal: float = 1.0
    final_goal: float = 10.0

    def table(self) -> FloatArray:
        return np.array((self.step, self.sub_goal, self.final_goal), dtype=np.float64)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ShapedReward(GoalReward):
    """The same rewards with potential-based shaping, see `PotentialReward`; distances are those of offsets.

    Attributes:
        step: reward of an ordinary step.
        sub_goal: reward of a step onto the due sub-goal.
        final_goal: reward of a step onto the due final goal.
        shaping: the potential. `straight_way`: what the way through all goals that are left is worth by these rewards,
            if nothing is in the way; `due_goal`: minus the distance to the due goal; `all_goals`: minus the distance
            through all goals that are left; `goals_reached`: their number.
        weight: factor of the potential; with 0 nothing is shaped.
        gamma: discount factor of `straight_way`. The steps themselves are shaped with that of the learner.
    """

    shaping: Literal["straight_way", "due_goal", "all_goals", "goals_reached"] = "straight_way"
    weight: float = 1.0
    gamma: Annotated[float, Field(ge=0, le=1)] = 0.9

    def potential(self, world: World, goals: IntArray) -> FloatArray:
        x, y = world.offset(goals)
        distance = (np.abs(x) + np.abs(y)).astype(np.float64)
        legs = np.take_along_axis(distance[..., 1:, :], np.asarray(goals)[..., :-1, np.newaxis], axis=-1)
        if self.shaping == "goals_reached":
            height = np.broadcast_to(np.arange(distance.shape[-2], dtype=np.float64)[:, np.newaxis], distance.shape)
        elif self.shaping == "straight_way":
            height = self._straight(distance, legs)
        else:
            if self.shaping == "all_goals":
                distance[..., :-1, :] += np.cumsum(legs[..., ::-1, :], axis=-2)[..., ::-1, :]
            height = -distance
        return self.weight * height

    def _straight(self, distance: FloatArray, legs: FloatArray) -> FloatArray:
        """Return what the straight way is worth, from the distance to the due goal and those between the goals."""
        height = np.empty_like(distance)
        after = np.full_like(distance[..., -1, :1], self.final_goal)
        for due in reversed(range(distance.shape[-2])):
            height[..., due, :] = self._way(distance[..., due, :], after)
            if due:
                after = self.sub_goal + self.gamma * self._way(legs[..., due - 1, :], after)
        return height

    def _way(self, distance: FloatArray, after: FloatArray) -> FloatArray:
        """Return what steps are worth of which the last one, onto a goal, is worth `after`."""
        before = np.maximum(distance - 1, 0)
        discount = self.gamma**before
        steps = before if self.gamma == 1 else (1 - discount) / (1 - self.gamma)
        way: FloatArray = self.step * steps + discount * after
        return way
