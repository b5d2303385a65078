"""Actions of one or more steps that may see: each has a step for every observation, a rule to stop, and a limit.

They are options in the sense of Sutton, Precup and Singh (1999): a policy and a stopping rule.
"""

from __future__ import annotations

from typing import Annotated, Literal, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass
from typing_extensions import Protocol, runtime_checkable

from rl_design_space._arrays import IntArray
from rl_design_space._strict import STRICT
from rl_design_space.design.identity import full_name
from rl_design_space.design.observing import Representation, SightedRepresentation
from rl_design_space.design.sight import Sight
from rl_design_space.design.world import MOVES, World, cell_count
from rl_design_space.errors import ConfigError

#: The step of an action that has nowhere to go: the agent stays where it is, and the step counts.
WAIT = len(MOVES)

#: Random layouts in which an action has to wait everywhere to be refused: in one of them it may have nowhere to go.
_LAYOUTS = 20

_Scalar = TypeVar("_Scalar", bound=np.generic)
_Propagation = Literal["primitives", "consistent", "none"]


class Behaviour(NamedTuple):
    """What actions do, by action, layout, success counter and cell.

    Attributes:
        steps: (n_actions, ..., n_goals, cells) int8, the step that each action makes there: a number of `MOVES`, or
            `WAIT`.
        stops: (n_actions, ..., n_goals, cells) bool, whether it stops on arriving there.
        marks: (..., n_goals, cells) int64, what the agent perceives: an action stops where it is not what it was when
            the action began. None if actions do not depend on it.
    """

    steps: NDArray[np.int8]
    stops: NDArray[np.bool_]
    marks: NDArray[np.int64] | None = None


@runtime_checkable
class ActionSet(Protocol):
    """A set of actions, and how they learn."""

    @property
    def reward(self) -> Literal["realised", "printed"]:
        """The return of an action of several steps, see `MultiStepActions`."""
        ...

    @property
    def sub_goal(self) -> Literal["continue", "stop"]:
        """Whether a due sub-goal on the way ends an action."""
        ...

    @property
    def n_actions(self) -> int:
        """Number of actions."""
        ...

    @property
    def primitives(self) -> bool:
        """Whether the first four actions are the primitive ones."""
        ...

    @property
    def labels(self) -> tuple[str, ...]:
        """A few words for each action; actions of one kind share them."""
        ...

    @property
    def propagation(self) -> str:
        """Other actions that learn from the cells passed."""
        ...

    @property
    def propagated_lengths(self) -> int:
        """Number of groups of four actions that learn from longer actions that contain them."""
        ...

    @property
    def repeats(self) -> bool:
        """Whether actions only repeat a step: action a makes step a % 4 up to its limit, equal in groups of four.

        Such actions need no `behaviour`.
        """
        ...

    def limits(self) -> NDArray[np.int32]:
        """Return the most steps of each action, (n_actions,) int32."""
        ...

    def behaviour(
        self, world: World, representation: Representation, goals: IntArray, codes: NDArray[np.int64]
    ) -> Behaviour:
        """Return what the actions do in one or many layouts.

        Args:
            world: where the agent moves.
            representation: what it observes.
            goals: (..., n_goals) cell numbers.
            codes: (..., n_goals, cells) observation codes of these layouts.
        """
        ...


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SeeingActions:
    """The primitive actions, and actions that depend on the observation: the base of sets of your own.

    A subclass names its actions and says what they do. Without any, this is the set of primitive actions.

    Attributes:
        primitives: whether the four primitive actions can be chosen, too.
        limit: the most steps of an action.
        propagation: other actions that are updated at the cells passed, after the action itself. `primitives`: one-step
            updates of the primitive action of each step, in the order of time; `consistent`: every action that would
            have made the same steps from a cell passed on and would have ended by itself, in the order of the actions,
            each in the order of time; `none`.
        reward: the return of an action of several steps: of the rewards received (`realised`), or as `printed` in the
            paper for multi-step actions.
        sub_goal: effect of a due sub-goal on the way: `continue` the action, or `stop` it there.
    """

    primitives: bool = True
    limit: Annotated[int, Field(ge=1, le=1_000_000)] = 100
    propagation: _Propagation = "primitives"
    reward: Literal["realised", "printed"] = "realised"
    sub_goal: Literal["continue", "stop"] = "continue"

    @model_validator(mode="after")
    def _leave_a_choice(self) -> SeeingActions:
        if self.n_actions < 2:
            raise ValueError(f"primitives={str(self.primitives).lower()}: fewer than two actions are left")
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the actions beside the primitive actions, in the order of `moves`."""
        return ()

    def moves(self, sight: Sight) -> NDArray[np.int8]:
        """Return the step of each named action, (n_names, ...) int8: a number of `MOVES`, or `WAIT`.

        Args:
            sight: what the observations show, of any shape (...).
        """
        return np.empty((0, *sight.counter.shape), dtype=np.int8)

    def stops(self, sight: Sight) -> NDArray[np.bool_]:
        """Return whether each named action stops on arriving, (n_names, ...) bool; by default where it would wait."""
        waits: NDArray[np.bool_] = self.moves(sight) == WAIT
        return waits

    def check(self, world: World, representation: Representation, n_goals: int) -> None:
        """Check that the actions can be used with this representation; called when a point is built.

        By default: that every named action moves somewhere. What a set with a `behaviour` of its own does is not known.

        Raises:
            ConfigError: they cannot.
        """
        if type(self).behaviour is not SeeingActions.behaviour:
            return
        waiting = list(range(len(self.names)))
        source = np.random.default_rng(0)
        for _ in range(_LAYOUTS):
            if not waiting:
                return
            codes = representation.observation(world, source.permutation(cell_count(world))[:n_goals])
            sight = sight_of(representation, world, n_goals, codes)
            moves = self.moves(sight)
            if np.shape(moves) != (len(self.names), *codes.shape):  # `behaviour` says so
                return
            waiting = [number for number in waiting if (np.asarray(moves[number]) == WAIT).all()]
        if waiting:
            shown = f"{full_name(type(representation))} with {n_goals} goals in {full_name(type(world))}"
            raise ConfigError(
                f"msa={full_name(type(self))}: {self.names[waiting[0]]} would never move: {shown} does not show where "
                "to; choose another representation, or leave the action out"
            )

    @property
    def n_actions(self) -> int:
        return len(MOVES) * self.primitives + len(self.names)

    @property
    def labels(self) -> tuple[str, ...]:
        return (
            *("action of 1 step",) * (len(MOVES) * self.primitives),
            *(name.replace("_", " ") for name in self.names),
        )

    @property
    def propagated_lengths(self) -> int:
        """1 if the primitive actions learn from the steps of the others."""
        return int(self.primitives and self.propagation == "primitives")

    @property
    def repeats(self) -> bool:
        return False

    def limits(self) -> NDArray[np.int32]:
        return np.array([1] * (4 * self.primitives) + [self.limit] * len(self.names), dtype=np.int32)

    def behaviour(
        self, world: World, representation: Representation, goals: IntArray, codes: NDArray[np.int64]
    ) -> Behaviour:
        sight = sight_of(representation, world, goals.shape[-1], codes)
        shape = (len(self.names), *codes.shape)
        steps = self._checked("moves", self.moves(sight), np.int8, shape)
        stops = self._checked("stops", self.stops(sight), np.bool_, shape)
        if self.primitives:
            own = np.arange(4, dtype=np.int8).reshape(4, *[1] * codes.ndim)
            steps = np.concatenate([np.broadcast_to(own, (4, *codes.shape)), steps])
            stops = np.concatenate([np.zeros((4, *codes.shape), dtype=np.bool_), stops])
        return Behaviour(steps, stops)

    def _checked(self, method: str, table: object, dtype: type[_Scalar], shape: tuple[int, ...]) -> NDArray[_Scalar]:
        if not isinstance(table, np.ndarray) or table.dtype != dtype or table.shape != shape:
            found = f"{table.dtype} of shape {table.shape}" if isinstance(table, np.ndarray) else type(table).__name__
            raise ConfigError(
                f"msa: {full_name(type(self))}.{method}() should give {np.dtype(dtype)} of shape {shape}, not {found}"
            )
        return table


def sight_of(representation: Representation, world: World, n_goals: int, codes: NDArray[np.int64]) -> Sight:
    """Return what observations show.

    Raises:
        ConfigError: the representation does not say what it shows.
    """
    if isinstance(representation, SightedRepresentation):
        return representation.sight(world, n_goals, codes)
    name = full_name(type(representation))
    raise ConfigError(f"representation: {name} has no method sight(), so actions that see cannot be used with it")
