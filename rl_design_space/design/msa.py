"""Multi-step actions (MSAs): actions that repeat one primitive move (paper, section 3.3)."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BeforeValidator, Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT


def _in_order(lengths: Any) -> Any:
    """A list from YAML is as good as a tuple; a set has no order to keep."""
    return tuple(lengths) if isinstance(lengths, list) else lengths


def _distinct(lengths: tuple[int, ...]) -> tuple[int, ...]:
    if len(set(lengths)) != len(lengths):
        raise ValueError("every length may stand in the list once")
    return lengths


_Length = Annotated[int, Field(ge=2, le=1_000_000)]
_Lengths = Annotated[
    tuple[_Length, ...],
    BeforeValidator(_in_order, json_schema_input_type=list[_Length]),
    AfterValidator(_distinct),
]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class MultiStepActions:
    """Sets of actions beside the 4 primitive moves, each of which repeats one move.

    An MSA of length p that is executed for k ≤ p moves, because the final goal or the step cap ends it, is
    updated once, with its return and the bootstrap of γ^k. What else it means is open in the paper, hence the
    fields beside `lengths`.

    Attributes:
        lengths: one set of actions each: set i repeats each move `lengths[i]` times.
        propagation: the shorter actions that learn from the cells passed, after the MSA itself. `primitives`:
            one-step updates of the primitive move at every cell, in the order of time; `all_shorter`: the same for
            every shorter length of the set, the primitive moves first; `none`.
        reward: the return of the MSA. `realised`: Σ γ^j r_j over the k rewards received, j = 0 … k - 1; `printed`:
            Σ γ^j r over j = 0 … k with the first move's reward throughout, as in the paper's formula. Shorter
            actions that learn by propagation get the rewards received all the same.
        sub_goal: what a due sub-goal met on the way does. `continue` goes on with the MSA (counter and reward change
            at that move), `stop` ends the MSA there.
    """

    lengths: _Lengths = ()
    propagation: Literal["primitives", "all_shorter", "none"] = "primitives"
    reward: Literal["realised", "printed"] = "realised"
    sub_goal: Literal["continue", "stop"] = "continue"

    def action_lengths(self) -> NDArray[np.int32]:
        """(1 + m,) int32, moves of every action length; the first is 1, the primitive moves."""
        return np.array((1, *self.lengths), dtype=np.int32)
