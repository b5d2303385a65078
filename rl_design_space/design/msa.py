"""Multi-step actions (MSAs): actions that repeat one primitive action (paper, section 3.3)."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BeforeValidator, Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT


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
            updates of every shorter length, the primitive actions first; `none`.
        reward: the return of the MSA. `realised`: Σ γ^j r_j over the k rewards received, j = 0 … k - 1; `printed`:
            Σ γ^j r over j = 0 … k with the reward of the first step throughout, as in the paper's formula. Shorter
            actions that are updated by propagation use the rewards received in either case.
        sub_goal: effect of a due sub-goal on the way: `continue` the MSA (counter and reward change at that step), or
            `stop` it there.
    """

    lengths: _Lengths = ()
    propagation: Literal["primitives", "all_shorter", "none"] = "primitives"
    reward: Literal["realised", "printed"] = "realised"
    sub_goal: Literal["continue", "stop"] = "continue"

    def action_lengths(self) -> NDArray[np.int32]:
        """Return the lengths of all actions in steps, (1 + m,) int32; the first is 1, that of primitive actions."""
        return np.array((1, *self.lengths), dtype=np.int32)
