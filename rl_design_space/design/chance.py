"""Worlds with chance: where a step leads is drawn from a table of outcomes and their probabilities."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field
from pydantic.dataclasses import dataclass
from typing_extensions import Protocol, runtime_checkable

from rl_design_space._arrays import FloatArray, IntArray
from rl_design_space._strict import STRICT
from rl_design_space.design import ways
from rl_design_space.design.identity import full_name
from rl_design_space.design.world import MOVES, Torus, Walled, World, _Grid, cell_count
from rl_design_space.errors import ConfigError

#: By step, the steps to its left and to its right: those of a step to the right are above and below.
_LEFT_OF, _RIGHT_OF = (2, 3, 1, 0), (3, 2, 0, 1)

Astray = Literal["sides", "left", "right", "others", "stays"]


class Outcomes(NamedTuple):
    """What each step may lead to.

    Attributes:
        cells: (4, cells, k) int32, the k cells that each of `MOVES` may lead to from each cell.
        probabilities: (4, cells, k) float64, their probabilities, which add up to 1.
    """

    cells: NDArray[np.int32]
    probabilities: FloatArray


@runtime_checkable
class StochasticWorld(World, Protocol):
    """A world in which chance decides where a step leads; `next_cell` is where it leads if nothing goes astray."""

    def outcomes(self) -> Outcomes:
        """Return what each step may lead to, and how probably, (4, cells, k) each."""
        ...


def slipped(next_cell: NDArray[np.int32], p: float, astray: Astray = "sides") -> Outcomes:
    """Return the outcomes of steps that go astray with a probability.

    Args:
        next_cell: (4, cells) where steps lead that do not.
        p: the probability.
        astray: where the others lead, see `Slip`.
    """
    here = np.arange(next_cell.shape[1], dtype=np.int32)[np.newaxis].repeat(len(MOVES), axis=0)
    to_the_left, to_the_right = next_cell[list(_LEFT_OF)], next_cell[list(_RIGHT_OF)]
    back = next_cell[[1, 0, 3, 2]]
    others = {
        "sides": (to_the_left, to_the_right),
        "left": (to_the_left,),
        "right": (to_the_right,),
        "others": (to_the_left, to_the_right, back),
        "stays": (here,),
    }[astray]
    shares = [1 - p, *[p / len(others)] * len(others)]
    cells = np.stack([next_cell, *others], axis=-1)
    return Outcomes(cells, np.broadcast_to(np.array(shares), cells.shape).copy())


def possible_cells(outcomes: Outcomes) -> NDArray[np.int32]:
    """Return all cells that can come next, (4 · k, cells); a cell itself in the place of outcomes that never happen."""
    cells, probabilities = (np.moveaxis(each, -1, 1).reshape(-1, each.shape[1]) for each in outcomes)
    return np.where(probabilities > 0, cells, np.arange(cells.shape[1], dtype=np.int32))


@dataclass(frozen=True, kw_only=True, config=STRICT)
class _Disturbed(_Grid):
    """A grid on which chance disturbs steps.

    Attributes:
        border: `torus`: a step over one border leads to the opposite side; `walled`: a step against it leaves the agent
            where it is.
    """

    border: Literal["torus", "walled"] = "torus"

    @property
    def undisturbed(self) -> Torus | Walled:
        """The same grid without chance."""
        return Torus(size=self.size) if self.border == "torus" else Walled(size=self.size)

    @property
    def reach(self) -> tuple[int, int]:
        return self.undisturbed.reach

    def _inside(self, x: IntArray, y: IntArray) -> tuple[IntArray, IntArray]:
        return self.undisturbed._inside(x, y)

    def _signed(self, difference: IntArray, side: int) -> IntArray:
        return self.undisturbed._signed(difference, side)


def refuse_chance(world: World, what: str) -> None:
    """Refuse a stochastic world where everything has to follow from the steps.

    Raises:
        ConfigError: the world is stochastic.
    """
    if isinstance(world, StochasticWorld):
        raise ConfigError(
            f"world: {full_name(type(world))} is stochastic; {what} are known for deterministic worlds only"
        )


def undisturbed(world: World) -> World:
    """Return a world without wind and slips, if it is one of this package: it has walls where pictures show them."""
    return world.undisturbed if isinstance(world, _Disturbed) else world


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Slip(_Disturbed):
    """Grid on which a step goes astray with a probability, each step of a multi-step action by itself.

    Attributes:
        size: d for d×d cells, or [dx, dy].
        border: `torus`: a step over one border leads to the opposite side; `walled`: a step against it leaves the agent
            where it is.
        p: probability that a step goes astray. With 0, everything is as on the grid without slips.
        astray: where it leads then: one cell to either of its `sides`, each as often; always to its `left`, or to its
            `right`, in the direction of the step; in any of the `others` of the four directions; or it `stays`.
    """

    p: Annotated[float, Field(ge=0, lt=1)] = 0.1
    astray: Astray = "sides"

    def outcomes(self) -> Outcomes:
        return slipped(self.next_cell(), self.p, self.astray)


def _in_order(strengths: Any) -> Any:
    return tuple(strengths) if isinstance(strengths, list) else strengths


_Strengths = Annotated[
    tuple[int, ...], Field(min_length=1), BeforeValidator(_in_order, json_schema_input_type=list[int])
]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Wind(_Disturbed):
    """Grid with a wind that carries the agent up after each step (Sutton and Barto, 2nd edition, Example 6.5).

    The wind is that of the column where the step begins. Without gusts it is always the same, and nothing is random;
    with them it varies by one, as in Exercise 6.10, where the probability is 1/3. Starts and goals lie on cells that
    can all be reached from each other.

    Attributes:
        size: d for d×d cells, or [dx, dy].
        border: `torus`: a step over one border leads to the opposite side; `walled`: a step against it leaves the agent
            where it is.
        strengths: cells that the wind carries up, by column from left to right; shorter or longer lists are stretched
            over the width. Negative ones carry down.
        gusts: probability that the wind is stronger by one cell, and the same that it is weaker; where the strength is
            0 there are none.
    """

    strengths: _Strengths = (0, 0, 0, 1, 1, 1, 2, 2, 1, 0)
    gusts: Annotated[float, Field(ge=0, le=0.5)] = 0.25

    def next_cell(self) -> NDArray[np.int32]:
        return self._carried(0)

    def outcomes(self) -> Outcomes:
        cells = np.stack([self._carried(change) for change in (0, 1, -1)], axis=-1)
        shares = np.array([1 - 2 * self.gusts, self.gusts, self.gusts])
        return Outcomes(cells, np.broadcast_to(shares, cells.shape).copy())

    def open_cells(self) -> NDArray[np.int32]:
        """Return the cells that can be reached from the top of the column with the least wind, and lead back there."""
        next_cell = possible_cells(self.outcomes())
        calmest = int(np.abs(self._by_column()).argmin())
        return np.flatnonzero(ways.reached_from(next_cell, calmest) & ways.leading_to(next_cell, calmest)).astype(
            np.int32
        )

    def _by_column(self) -> NDArray[np.int64]:
        """Return the strength of the wind in each column."""
        width, _ = self.shape
        return np.array(self.strengths)[np.arange(width) * len(self.strengths) // width]

    def _carried(self, change: int) -> NDArray[np.int32]:
        """Return where steps lead, (4, cells), where the wind is so much stronger than usual."""
        width, _ = self.shape
        strengths = self._by_column()
        up = (strengths + change * np.sign(strengths))[np.arange(cell_count(self)) % width]
        y, x = np.divmod(super().next_cell(), width)
        x, y = self._inside(x, y - up)
        return (y * width + x).astype(np.int32)
