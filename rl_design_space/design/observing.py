"""What representations do: the protocols that their classes fulfil."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Protocol, runtime_checkable

from rl_design_space._arrays import IntArray
from rl_design_space.design.sight import Sight
from rl_design_space.design.world import World


@runtime_checkable
class Representation(Protocol):
    """Map from success counter and cell to an observation code. The agent cannot tell states of equal code apart."""

    def observation(self, world: World, goals: IntArray) -> NDArray[np.int64]:
        """Return the observation codes of one or many layouts.

        Args:
            world: where the agent moves.
            goals: (..., n_goals) cell numbers, in the order in which they are due.

        Returns:
            (..., n_goals, cells) int64, indexed by success counter and cell. A code has the same meaning in every
            layout, so a Q-matrix can be transferred from one layout or world to another.
        """
        ...


@runtime_checkable
class SizedRepresentation(Representation, Protocol):
    """A representation whose state space the paper counts in Table 2."""

    def published_size(self, world: World, n_goals: int) -> int:
        """Return the number of states by the formula of Table 2."""
        ...

    def spanned_size(self, world: World, n_goals: int) -> int:
        """Return the number of codes that `observation` can return; the largest code is one less."""
        ...


@runtime_checkable
class PortableRepresentation(Representation, Protocol):
    """A representation that numbers equal observations differently in other worlds, and can do without."""

    def portable(self, world: World, goals: IntArray) -> NDArray[np.int64]:
        """Return codes as `observation` does, which mean the same in every world: what stages carry values by."""
        ...


@runtime_checkable
class SightedRepresentation(Representation, Protocol):
    """A representation that says what its observations show, which actions can depend on."""

    def sight(self, world: World, n_goals: int, codes: NDArray[np.int64]) -> Sight:
        """Return what observations show.

        Args:
            world: where the agent moves.
            n_goals: number of goals.
            codes: (...) observation codes. What they show follows from them alone, not from their place in the array.
        """
        ...


@runtime_checkable
class FittedRepresentation(Representation, Protocol):
    """A representation that does not fit every world or every number of goals."""

    def check(self, world: World, n_goals: int) -> None:
        """Check that the representation can be used; called when a point is built.

        Raises:
            ConfigError: it cannot.
        """
        ...


class Attribute(NamedTuple):
    """A part of what an agent observes.

    Attributes:
        values: whole numbers that are broadcast to (..., n_goals, cells), from 0 on. They mean the same in every
            layout and world.
        base: more than the largest of them, the same in every layout and world.
    """

    values: IntArray
    base: int


@runtime_checkable
class AttributedRepresentation(Representation, Protocol):
    """A representation that says of what attributes its observations consist."""

    def attributes(self, world: World, goals: IntArray) -> Mapping[str, Attribute]:
        """Return the attributes by name; together they tell apart what `observation` does.

        Args:
            world: where the agent moves.
            goals: (..., n_goals) cell numbers, in the order in which they are due.
        """
        ...
