"""State representations: what the agent observes of agent, goals and success counter (paper, section 3.1).

The success counter s is the number of goals reached in order, so goal s is due. The state after the final goal is
terminal and has no observation.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import IntArray
from rl_design_space._strict import STRICT
from rl_design_space.design.observing import Attribute
from rl_design_space.design.sight import UNKNOWN, Sight, unseen
from rl_design_space.design.world import World, cell_count
from rl_design_space.errors import ConfigError

_LARGEST_CODE = int(np.iinfo(np.int64).max)

#: More than any world has cells along a side; a prime number, because hash tables take the low bits of codes.
SIDES = 1_000_003

#: Goals that an observation covers: those not yet reached; all of them, as Table 2 counts them; or the due one alone.
_ObservedGoals = Literal["all", "remaining", "due"]
#: Name of the attribute that all representations have.
COUNTER = "counter"


def encode(digits: IntArray, base: int, goals: _ObservedGoals = "all") -> NDArray[np.int64]:
    """Encode one digit per goal, and the success counter, as a single number.

    Args:
        digits: (..., n_goals, cells) whole numbers, each in 0 … base - 1.
        base: number of values of a digit.
        goals: with "remaining", the digits of goals already reached are 0; with "due", those of all but the due goal.

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
    elif goals == "due":
        observed = terms
    else:
        observed = terms.sum(axis=-2, keepdims=True)
    counter = base**n_goals * np.arange(n_goals, dtype=np.int64)[:, np.newaxis]
    codes: NDArray[np.int64] = counter + observed
    return codes


def _counter(n_goals: int) -> Attribute:
    """Return the success counter as an attribute."""
    return Attribute(np.arange(n_goals)[:, np.newaxis], n_goals)


def place_attributes(x: IntArray, y: IntArray, n_goals: int) -> dict[str, Attribute]:
    """Return a place, (cells,) along x and along y, and the success counter as attributes."""
    return {"x": Attribute(x, SIDES), "y": Attribute(y, SIDES), COUNTER: _counter(n_goals)}


def _of_goals(digits: IntArray, base: int, goals: _ObservedGoals) -> dict[str, Attribute]:
    """Return what is observed of each goal, and the success counter, as attributes; arguments as of `encode`."""
    n_goals = digits.shape[-2]
    counter, found = np.arange(n_goals)[:, np.newaxis], {}
    for goal in range(n_goals):
        is_observed = {"all": counter >= 0, "remaining": counter <= goal, "due": counter == goal}[goals]
        found[f"goal{goal + 1}"] = Attribute(digits[..., goal, np.newaxis, :] * is_observed, base)
    return {**found, COUNTER: _counter(n_goals)}


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
        codes = (np.arange(n_goals, dtype=np.int64)[:, np.newaxis] * SIDES + y) * SIDES + x
        return np.broadcast_to(codes, (*goals.shape[:-1], n_goals, cell_count(world)))

    def sight(self, world: World, n_goals: int, codes: NDArray[np.int64]) -> Sight:
        counter, cell = np.divmod(codes, cell_count(world))
        nothing = unseen((n_goals, *codes.shape))
        return Sight(world, counter, nothing, nothing, cell)

    def attributes(self, world: World, goals: IntArray) -> Mapping[str, Attribute]:
        y, x = np.divmod(np.arange(cell_count(world)), world.shape[0])
        return place_attributes(x, y, goals.shape[-1])

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
        goals: goals whose distances are observed: those `remaining`, `all`, or the `due` one alone.
    """

    goals: _ObservedGoals = "remaining"

    def observation(self, world: World, goals: IntArray) -> NDArray[np.int64]:
        return encode(self._digits(world, goals), self._values(world), self.goals)

    def portable(self, world: World, goals: IntArray) -> NDArray[np.int64]:
        return encode(self._digits(world, goals), _largest_base(goals.shape[-1]), self.goals)

    def attributes(self, world: World, goals: IntArray) -> Mapping[str, Attribute]:
        return _of_goals(self._digits(world, goals), _largest_base(goals.shape[-1]), self.goals)

    def sight(self, world: World, n_goals: int, codes: NDArray[np.int64]) -> Sight:
        nothing = unseen((n_goals, *codes.shape))
        return Sight(world, codes // self._values(world) ** n_goals, nothing, nothing, np.full_like(codes, -1))

    def published_size(self, world: World, n_goals: int) -> int:
        width, height = world.shape
        return int((width // 2 + height // 2) ** n_goals * n_goals)

    def spanned_size(self, world: World, n_goals: int) -> int:
        return int(self._values(world) ** n_goals * n_goals)

    @staticmethod
    def _digits(world: World, goals: IntArray) -> IntArray:
        x, y = world.offset(goals)
        return np.abs(x) + np.abs(y)

    @staticmethod
    def _values(world: World) -> int:
        return sum(world.reach) + 1


def _largest_base(n_goals: int) -> int:
    """Return the largest base whose codes of this many digits fit 63 bits."""
    base = int((_LARGEST_CODE / n_goals) ** (1 / n_goals))
    return next(each for each in range(base + 1, 0, -1) if each**n_goals * n_goals <= _LARGEST_CODE)


#: Digits of directions, one byte each, because a simulation creates millions of them.
_HERE, _RIGHT, _LEFT, _ABOVE, _BELOW = _DIGITS = tuple(np.int8(digit) for digit in range(5))


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Direction:
    """Direction from the agent to the goals (here, right, left, above, below) and the success counter.

    Size 5^n·n, whatever the world. Two rules fit the paper's one example, (5,5)→(7,7) and (5,5)→(8,3)
    both "right".

    Attributes:
        rule: which of two directions is observed: along the `dominant_axis`, the one with the larger offset, horizontal
            when both are equal; or `horizontal_first`, horizontal until the column is right, then vertical.
        goals: goals whose directions are observed: those `remaining`, `all`, or the `due` one alone.
    """

    rule: Literal["dominant_axis", "horizontal_first"] = "dominant_axis"
    goals: _ObservedGoals = "remaining"

    def observation(self, world: World, goals: IntArray) -> NDArray[np.int64]:
        return encode(self._digits(world, goals), len(_DIGITS), self.goals)

    def attributes(self, world: World, goals: IntArray) -> Mapping[str, Attribute]:
        return _of_goals(self._digits(world, goals), len(_DIGITS), self.goals)

    def _digits(self, world: World, goals: IntArray) -> IntArray:
        x, y = world.offset(goals)
        horizontal = np.abs(x) >= np.abs(y) if self.rule == "dominant_axis" else x != 0
        along_x = np.where(x > 0, _RIGHT, _LEFT)
        along_y = np.where(y > 0, _BELOW, _ABOVE)
        here = (x == 0) & (y == 0)
        digits: IntArray = np.where(here, _HERE, np.where(horizontal, along_x, along_y))
        return digits

    def sight(self, world: World, n_goals: int, codes: NDArray[np.int64]) -> Sight:
        number = np.arange(n_goals).reshape(-1, *[1] * codes.ndim)
        counter, digit = codes // 5**n_goals, codes // 5**number % 5
        # Above or below: of the dominant axis alone, or because the column is right.
        beside = 0 if self.rule == "horizontal_first" else UNKNOWN
        x = np.array((0, 1, -1, beside, beside), dtype=np.int8)[digit]
        y = np.array((0, UNKNOWN, UNKNOWN, -1, 1), dtype=np.int8)[digit]
        # Goals that are not observed have the digit of "here".
        hidden = (number < counter) & (self.goals != "all") | (number > counter) & (self.goals == "due")
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
