"""Local controllers as actions: the paper's "restricted though powerful" ones, which learning coordinates."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BeforeValidator
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import IntArray
from rl_design_space._strict import STRICT
from rl_design_space.design.actions import WAIT, SeeingActions, sight_of
from rl_design_space.design.chance import undisturbed
from rl_design_space.design.identity import full_name
from rl_design_space.design.observing import Representation
from rl_design_space.design.sight import Sight
from rl_design_space.design.world import World, cell_count
from rl_design_space.errors import ConfigError

_RIGHT, _LEFT, _ABOVE, _BELOW = (np.int8(move) for move in range(4))
_WAIT = np.int8(WAIT)
#: The steps on whose right-hand side a wall is, by step: of a step to the right it is below, and so on.
_RIGHT_HAND = (3, 2, 0, 1)

_Name = Literal["goal_along_x", "goal_along_y", "along_wall", "back_to_sub_goal"]


def _in_order(names: Any) -> Any:
    return tuple(names) if isinstance(names, list) else names


def _distinct(names: tuple[str, ...]) -> tuple[str, ...]:
    if len(set(names)) != len(names):
        raise ValueError("every controller should be listed once")
    return names


_Names = Annotated[
    tuple[_Name, ...], BeforeValidator(_in_order, json_schema_input_type=list[_Name]), AfterValidator(_distinct)
]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Controllers(SeeingActions):
    """Controllers that lead the agent several steps, as far as its observation shows where to.

    Where the observation does not show it, a controller waits: it makes one step that leaves the agent where it is. It
    stops on arriving where it would wait. A controller that would wait everywhere is refused.

    Attributes:
        controllers: `goal_along_x`: towards the due goal along x, until level with it; `goal_along_y`: the same along
            y; `along_wall`: with a wall on the right-hand side, up to the next turn of the wall; `back_to_sub_goal`:
            back to the goal reached last, along x first.
        primitives: whether the four primitive actions can be chosen, too.
        limit: the most steps of a controller.
        propagation: other actions that are updated at the cells passed, after the controller itself, see
            `SeeingActions`.
        reward: the return of a controller: of the rewards received (`realised`), or as `printed` in the paper for
            multi-step actions.
        sub_goal: effect of a due sub-goal on the way: `continue`, which is towards the goal that is due then, or
            `stop`.
    """

    controllers: _Names = ("goal_along_x", "goal_along_y")

    @property
    def names(self) -> tuple[str, ...]:
        return self.controllers

    def moves(self, sight: Sight) -> NDArray[np.int8]:
        shape = (len(self.controllers), *sight.counter.shape)
        return np.array([_STEPS[name](sight) for name in self.controllers], dtype=np.int8).reshape(shape)

    def stops(self, sight: Sight) -> NDArray[np.bool_]:
        stops: NDArray[np.bool_] = self.moves(sight) == WAIT
        if "along_wall" in self.controllers:
            stops[self.controllers.index("along_wall")] |= sight.of_cell(_wall_turns(sight.world), 1).astype(np.bool_)
        return stops

    def check(self, world: World, representation: Representation, n_goals: int) -> None:
        """Check that every controller moves somewhere.

        Raises:
            ConfigError: the observation of no cell shows a controller where to go.
        """
        goals = np.arange(n_goals)
        codes = representation.observation(world, goals)
        moves = self.moves(sight_of(representation, world, n_goals, codes))
        for name, steps in zip(self.controllers, moves, strict=True):
            if (steps == WAIT).all():
                shown = f"{full_name(type(representation))} with {n_goals} goals in {full_name(type(world))}"
                raise ConfigError(
                    f"msa.controllers: {name} would never move: {shown} does not show {_NEEDS[name]}; choose another "
                    "representation, or leave the controller out"
                )


def _goal_along_x(sight: Sight) -> NDArray[np.int8]:
    return _along_x(sight.due_goal()[0])


def _goal_along_y(sight: Sight) -> NDArray[np.int8]:
    return _along_y(sight.due_goal()[1])


def _back_to_sub_goal(sight: Sight) -> NDArray[np.int8]:
    x, y = sight.last_goal()
    step = _along_x(x)
    return np.where(step == _WAIT, _along_y(y), step)


def _along_wall(sight: Sight) -> NDArray[np.int8]:
    return sight.of_cell(_wall_steps(sight.world), WAIT).astype(np.int8)


def _along_x(sign: NDArray[np.int8]) -> NDArray[np.int8]:
    return _by_sign(_LEFT, _RIGHT)[sign + 1]


def _along_y(sign: NDArray[np.int8]) -> NDArray[np.int8]:
    return _by_sign(_ABOVE, _BELOW)[sign + 1]


def _by_sign(negative: np.int8, positive: np.int8) -> NDArray[np.int8]:
    """Return the steps for the signs -1, 0, 1 and `UNKNOWN`, which is 2."""
    return np.array((negative, _WAIT, positive, _WAIT), dtype=np.int8)


def _wall_steps(world: World) -> NDArray[np.int8]:
    """Return the step along the wall, by cell: the first that is free and has a wall on its right-hand side."""
    blocked = undisturbed(world).next_cell() == np.arange(cell_count(world))
    steps = np.full(cell_count(world), _WAIT)
    for move in reversed(range(4)):
        steps[blocked[_RIGHT_HAND[move]] & ~blocked[move]] = move
    return steps


def _wall_turns(world: World) -> IntArray:
    """Return whether the step along the wall into a cell goes in another direction than the one out of it, by cell."""
    steps, next_cell = _wall_steps(world), undisturbed(world).next_cell()
    turns = np.zeros(len(steps), dtype=np.int8)
    (walled,) = np.nonzero(steps != WAIT)
    ahead = next_cell[steps[walled], walled]
    turns[ahead[steps[ahead] != steps[walled]]] = 1
    return turns


_STEPS: dict[str, Callable[[Sight], NDArray[np.int8]]] = {
    "goal_along_x": _goal_along_x,
    "goal_along_y": _goal_along_y,
    "along_wall": _along_wall,
    "back_to_sub_goal": _back_to_sub_goal,
}
#: What a controller has to see.
_NEEDS = {
    "goal_along_x": "on which side the due goal lies along x",
    "goal_along_y": "on which side the due goal lies along y",
    "along_wall": "the agent's cell beside a wall",
    "back_to_sub_goal": "where the goal reached last lies",
}
