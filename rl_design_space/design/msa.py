"""Multi-step actions (MSAs): actions that repeat one primitive action (paper, section 3.3)."""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BeforeValidator, Field
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import IntArray
from rl_design_space._strict import STRICT
from rl_design_space.design.actions import Behaviour
from rl_design_space.design.identity import absent_as
from rl_design_space.design.observing import Representation
from rl_design_space.design.world import MOVES, World


def _in_order(lengths: Any) -> Any:
    """Convert a list from YAML to a tuple; anything else, such as a set without an order, is left to pydantic."""
    return tuple(lengths) if isinstance(lengths, list) else lengths


def _distinct(lengths: tuple[int, ...]) -> tuple[int, ...]:
    if len(set(lengths)) != len(lengths):
        raise ValueError("every length should be listed once")
    return lengths


_Length = Annotated[int, Field(ge=2, le=1_000_000)]
_Lengths = Annotated[
    tuple[_Length, ...],
    BeforeValidator(_in_order, json_schema_input_type=list[_Length]),
    AfterValidator(_distinct),
]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class MultiStepActions:
    """Sets of actions beside the 4 primitive actions, each of which repeats one primitive action.

    An MSA of length p that makes k ≤ p steps, because the final goal or the step cap ends it, is updated once, with
    its return and the bootstrap of γ^k. The fields beside `lengths` are readings of what the paper leaves open.

    Attributes:
        lengths: length of each set in steps: set i repeats each primitive action `lengths[i]` times.
        propagation: shorter actions that are updated at the cells passed, after the MSA itself. `primitives`:
            one-step updates of the primitive action at every cell, in the order of time; `all_shorter`: also
            updates of every shorter length, the primitive actions first; `consistent`: every action that would have
            made the same steps from a cell passed on and would have ended by itself, in the order of the actions, each
            in the order of time; `none`.
        reward: the return of the MSA. `realised`: Σ γ^j r_j over the k rewards received, j = 0 … k - 1; `printed`:
            Σ γ^j r over j = 0 … k with the reward of the first step throughout, as in the paper's formula. Shorter
            actions that are updated by propagation use the rewards received in either case.
        sub_goal: effect of a due sub-goal on the way: `continue` the MSA (counter and reward change at that step), or
            `stop` it there.
        until: where an MSA stops: at its `length`; or sooner, where the observation is another one than where it began
            (`observation_changes`), or where the observation of the due goal alone is (`due_goal_observation_changes`).
            Primitive actions always make one step.
    """

    lengths: _Lengths = ()
    propagation: Literal["primitives", "all_shorter", "consistent", "none"] = "primitives"
    reward: Literal["realised", "printed"] = "realised"
    sub_goal: Literal["continue", "stop"] = "continue"
    until: Literal["length", "observation_changes", "due_goal_observation_changes"] = field(
        default="length", metadata=absent_as("length", listed=False)
    )

    def action_lengths(self) -> NDArray[np.int32]:
        """Return the lengths of all actions in steps, (1 + m,) int32; the first is 1, that of primitive actions."""
        return np.array((1, *self.lengths), dtype=np.int32)

    @property
    def n_actions(self) -> int:
        return len(MOVES) * (1 + len(self.lengths))

    @property
    def primitives(self) -> bool:
        return True

    @property
    def labels(self) -> tuple[str, ...]:
        most = "" if self.until == "length" else "at most "
        longer = [f"action of {most}{length} steps" for length in self.lengths]
        return tuple(label for label in ("action of 1 step", *longer) for _ in MOVES)

    @property
    def propagated_lengths(self) -> int:
        return {"primitives": 1, "all_shorter": 1 + len(self.lengths)}.get(self.propagation, 0)

    @property
    def repeats(self) -> bool:
        return self.until == "length" and self.propagation != "consistent"

    def limits(self) -> NDArray[np.int32]:
        return np.repeat(self.action_lengths(), len(MOVES))

    def behaviour(
        self, world: World, representation: Representation, goals: IntArray, codes: NDArray[np.int64]
    ) -> Behaviour:
        steps = np.arange(self.n_actions, dtype=np.int8) % np.int8(len(MOVES))
        shape = (self.n_actions, *codes.shape)
        marks = None
        if self.until == "observation_changes":
            marks = codes
        elif self.until == "due_goal_observation_changes":
            # One layout of a single goal for each success counter: the goal that is due there.
            marks = representation.observation(world, goals[..., np.newaxis])[..., 0, :]
        return Behaviour(
            np.broadcast_to(steps.reshape(-1, *[1] * codes.ndim), shape), np.zeros(shape, dtype=np.bool_), marks
        )
