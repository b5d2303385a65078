"""State representations: what the agent observes of agent, goals and success counter (paper, section 3.1).

The success counter s is the number of goals reached in order, so goal s is due. The state after the final goal is
terminal and has no observation.
"""

from __future__ import annotations

import hashlib
from typing import Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import IntArray
from rl_design_space._strict import STRICT
from rl_design_space.design.sight import UNKNOWN, Sight, unseen
from rl_design_space.design.world import World, cell_count
from rl_design_space.errors import ConfigError

_LARGEST_CODE = int(np.iinfo(np.int64).max)

#: More than any world has cells along a side; a prime number, because hash tables take the low bits of codes.
_SIDES = 1_000_003

#: Goals that an observation covers: those not yet reached, or all of them, as Table 2 counts them.
_ObservedGoals = Literal["all", "remaining"]


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


def encode(digits: IntArray, base: int, goals: _ObservedGoals = "all") -> NDArray[np.int64]:
    """Encode one digit per goal, and the success counter, as a single number.

    Args:
        digits: (..., n_goals, cells) whole numbers, each in 0 … base - 1.
        base: number of values of a digit.
        goals: with "remaining", the digits of goals already reached are 0.

    Returns:
        (..., n_goals, cells) int64: s · base^n + sum over goals i of digit_i · base^i.

    Raises:
        ConfigError: base or a digit is no whole number, or a digit is not in 0 … base - 1.
        ValueError: the codes would not fit 64 bits.
    """
    base = _checked_base(digits, base)
    n_goals = digits.shape[-2]
    if base**n_goals * n_goals > _LARGEST_CODE:
        raise ValueError(
            f"task.goals={n_goals}: {base} values per goal need codes of more than 64 bits; use fewer goals"
        )
    places = base ** np.arange(n_goals, dtype=np.int64)[:, np.newaxis]
    terms = digits * places
    if goals == "remaining":
        # Summed from the last goal on: the sum from goal s on is that of the goals which remain at counter s.
        observed = np.cumsum(terms[..., ::-1, :], axis=-2)[..., ::-1, :]
    else:
        observed = terms.sum(axis=-2, keepdims=True)
    counter = base**n_goals * np.arange(n_goals, dtype=np.int64)[:, np.newaxis]
    codes: NDArray[np.int64] = counter + observed
    return codes


def _checked_base(digits: IntArray, base: int) -> int:
    """Return the base as a Python number, which does not overflow; refuse digits that are not in 0 … base - 1."""
    call = f"encode(digits, base={base})"
    if digits.dtype.kind not in "iub" or not isinstance(base, (int, np.integer)):
        raise ConfigError(f"{call}: should be whole numbers, not {digits.dtype} and {type(base).__name__}")
    # As unsigned numbers, negative digits are the largest ones: one pass finds both kinds.
    if digits.size and digits.view(f"u{digits.itemsize}").max() >= base:
        raise ConfigError(
            f"{call}: digits should be from 0 to {base - 1}, but are from {digits.min()} to {digits.max()}; "
            "different observations would share a code"
        )
    return int(base)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class AdHoc:
    """The agent's cell and the success counter; goals are implicit. Size dx·dy·n."""

    def observation(self, world: World, goals: IntArray) -> NDArray[np.int64]:
        n_goals, cells = goals.shape[-1], cell_count(world)
        codes = np.arange(n_goals * cells, dtype=np.int64).reshape(n_goals, cells)
        return np.broadcast_to(codes, (*goals.shape[:-1], n_goals, cells))

    def portable(self, world: World, goals: IntArray) -> NDArray[np.int64]:
        n_goals = goals.shape[-1]
        y, x = np.divmod(np.arange(cell_count(world), dtype=np.int64), world.shape[0])
        codes = (np.arange(n_goals, dtype=np.int64)[:, np.newaxis] * _SIDES + y) * _SIDES + x
        return np.broadcast_to(codes, (*goals.shape[:-1], n_goals, cell_count(world)))

    def sight(self, world: World, n_goals: int, codes: NDArray[np.int64]) -> Sight:
        counter, cell = np.divmod(codes, cell_count(world))
        nothing = unseen((n_goals, *codes.shape))
        return Sight(world, counter, nothing, nothing, cell)

    def published_size(self, world: World, n_goals: int) -> int:
        return cell_count(world) * n_goals

    def spanned_size(self, world: World, n_goals: int) -> int:
        return cell_count(world) * n_goals


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Distance:
    """Manhattan distances from the agent to the goals, and the success counter.

    On a torus a distance has 2⌊d/2⌋ + 1 values, zero among them; the formula of Table 2,
    (⌊dx/2⌋ + ⌊dy/2⌋)^n · n, counts one less.

    Attributes:
        goals: goals whose distances are observed: those `remaining`, or `all`.
    """

    goals: _ObservedGoals = "remaining"

    def observation(self, world: World, goals: IntArray) -> NDArray[np.int64]:
        return self._encoded(world, goals, self._values(world))

    def portable(self, world: World, goals: IntArray) -> NDArray[np.int64]:
        return self._encoded(world, goals, _largest_base(goals.shape[-1]))

    def sight(self, world: World, n_goals: int, codes: NDArray[np.int64]) -> Sight:
        nothing = unseen((n_goals, *codes.shape))
        return Sight(world, codes // self._values(world) ** n_goals, nothing, nothing, np.full_like(codes, -1))

    def published_size(self, world: World, n_goals: int) -> int:
        width, height = world.shape
        return int((width // 2 + height // 2) ** n_goals * n_goals)

    def spanned_size(self, world: World, n_goals: int) -> int:
        return int(self._values(world) ** n_goals * n_goals)

    def _encoded(self, world: World, goals: IntArray, base: int) -> NDArray[np.int64]:
        x, y = world.offset(goals)
        return encode(np.abs(x) + np.abs(y), base, self.goals)

    @staticmethod
    def _values(world: World) -> int:
        return sum(world.reach) + 1


def _largest_base(n_goals: int) -> int:
    """Return the largest base whose codes of this many digits fit 63 bits."""
    base = int((_LARGEST_CODE / n_goals) ** (1 / n_goals))
    return next(each for each in range(base + 1, 0, -1) if each**n_goals * n_goals <= _LARGEST_CODE)


#: Digits of directions, one byte each, because a simulation creates millions of them.
_HERE, _RIGHT, _LEFT, _ABOVE, _BELOW = (np.int8(digit) for digit in range(5))


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Direction:
    """Direction from the agent to the goals (here, right, left, above, below) and the success counter.

    Size 5^n·n, whatever the world. Two rules fit the paper's one example, (5,5)→(7,7) and (5,5)→(8,3)
    both "right".

    Attributes:
        rule: which of two directions is observed: along the `dominant_axis`, the one with the larger offset, horizontal
            when both are equal; or `horizontal_first`, horizontal until the column is right, then vertical.
        goals: goals whose directions are observed: those `remaining`, or `all`.
    """

    rule: Literal["dominant_axis", "horizontal_first"] = "dominant_axis"
    goals: _ObservedGoals = "remaining"

    def observation(self, world: World, goals: IntArray) -> NDArray[np.int64]:
        x, y = world.offset(goals)
        horizontal = np.abs(x) >= np.abs(y) if self.rule == "dominant_axis" else x != 0
        along_x = np.where(x > 0, _RIGHT, _LEFT)
        along_y = np.where(y > 0, _BELOW, _ABOVE)
        here = (x == 0) & (y == 0)
        return encode(np.where(here, _HERE, np.where(horizontal, along_x, along_y)), 5, self.goals)

    def sight(self, world: World, n_goals: int, codes: NDArray[np.int64]) -> Sight:
        number = np.arange(n_goals).reshape(-1, *[1] * codes.ndim)
        counter, digit = codes // 5**n_goals, codes // 5**number % 5
        # Above or below: of the dominant axis alone, or because the column is right.
        beside = 0 if self.rule == "horizontal_first" else UNKNOWN
        x = np.array((0, 1, -1, beside, beside), dtype=np.int8)[digit]
        y = np.array((0, UNKNOWN, UNKNOWN, -1, 1), dtype=np.int8)[digit]
        # Goals that are not observed have the digit of "here".
        hidden = (number < counter) & (self.goals == "remaining")
        unknown = np.int8(UNKNOWN)
        x, y = np.where(hidden, unknown, x), np.where(hidden, unknown, y)
        return Sight(world, counter, x, y, np.full_like(codes, -1))

    def published_size(self, world: World, n_goals: int) -> int:
        return int(5**n_goals * n_goals)

    def spanned_size(self, world: World, n_goals: int) -> int:
        return int(5**n_goals * n_goals)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Direct:
    """The full Markov state: the agent's cell, all goal positions and the success counter.

    The caption of Table 2 counts (dx·dy)^n · n states; with the agent's own cell it is (dx·dy)^(n+1) · n.
    Goals do not change within a period, so there `direct` learns exactly as `ad_hoc` does.

    Where the codes do not fit 64 bits, a digest replaces the goal positions: codes of one layout stay distinct, and two
    layouts share codes only if their digests collide. Actions that see cannot see goals in a digest.
    """

    def observation(self, world: World, goals: IntArray) -> NDArray[np.int64]:
        n_goals, cells = goals.shape[-1], cell_count(world)
        states = n_goals * cells
        if self.spanned_size(world, n_goals) <= _LARGEST_CODE:
            layout = goals.astype(np.int64) @ cells ** np.arange(n_goals, dtype=np.int64)
        else:
            layout = np.apply_along_axis(_digest, -1, goals, _LARGEST_CODE // states)
        within_layout = np.arange(states, dtype=np.int64).reshape(n_goals, cells)
        codes: NDArray[np.int64] = within_layout + states * layout[..., np.newaxis, np.newaxis]
        return codes

    def sight(self, world: World, n_goals: int, codes: NDArray[np.int64]) -> Sight:
        cells = cell_count(world)
        layout, state = np.divmod(codes, n_goals * cells)
        counter, cell = np.divmod(state, cells)
        if self.spanned_size(world, n_goals) > _LARGEST_CODE:
            nothing = unseen((n_goals, *codes.shape))
            return Sight(world, counter, nothing, nothing, cell)
        goals = layout // cells ** np.arange(n_goals).reshape(-1, *[1] * codes.ndim) % cells
        present = np.zeros(cells, dtype=np.bool_)
        present[goals] = True
        place = np.cumsum(present) - 1
        x, y = (np.sign(way).astype(np.int8) for way in world.offset(np.flatnonzero(present)))
        return Sight(world, counter, x[place[goals], cell], y[place[goals], cell], cell)

    def published_size(self, world: World, n_goals: int) -> int:
        return int(cell_count(world) ** n_goals * n_goals)

    def spanned_size(self, world: World, n_goals: int) -> int:
        return int(cell_count(world) ** (n_goals + 1) * n_goals)


def _digest(goals: IntArray, values: int) -> int:
    """Return a number in 0 … values - 1 for a list of goals, the same in every process."""
    digest = hashlib.blake2b(goals.astype("<i8").tobytes(), digest_size=8).digest()
    return int.from_bytes(digest, "little") % values
