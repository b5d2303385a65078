"""Marks: the outcome of a claim over all of its specifications, in a few words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

#: A claim holds if it does under at least this share of its specifications, or of those with the named choices; it
#: fails if it does not under at least this share of them.
MOSTLY = 0.95
#: A specification is clear if at least this share of the resamples come out as the measured value does.
CLEAR = 0.975
#: Choices are named if so many specifications have them, or more.
_FEWEST = 6
#: Most choices that are named together.
_MOST_NAMED = 2


class Mark(StrEnum):
    """The outcome of a claim."""

    HOLDS = "holds"
    UNDER = "holds under"
    NOWHERE = "does not hold under anything tried"
    OPEN = "cannot be told"


@dataclass(frozen=True)
class Marked:
    """A claim with its mark.

    Attributes:
        mark: the outcome.
        share: share of the specifications under which the claim holds; NaN if there are none.
        clear: share of the specifications whose outcome is clear.
        choices: those under which it holds; empty unless the mark is `UNDER`.
        within: share of the specifications with these choices under which it holds; NaN if there are none.
    """

    mark: Mark
    share: float
    clear: float
    choices: tuple[str, ...] = ()
    within: float = float("nan")


def marked(
    holds: NDArray[np.bool_], certainty: NDArray[np.float64], choices: Mapping[str, NDArray[np.bool_]]
) -> Marked:
    """Return the mark of a claim.

    Args:
        holds: (specifications,) whether it holds under each.
        certainty: (specifications,) share of the resamples that come out in the same way; NaN where that is not known.
        choices: (specifications,) by name of a choice, whether each specification makes it.
    """
    if not len(holds):
        return Marked(Mark.OPEN, float("nan"), float("nan"))
    clearly = np.nan_to_num(certainty) >= CLEAR
    share, clear = float(holds.mean()), float(clearly.mean())
    if share >= MOSTLY:
        return Marked(Mark.HOLDS, share, clear)
    if not (holds & clearly).any():
        fails = share <= 1 - MOSTLY and (~holds & clearly).mean() > 0.5
        return Marked(Mark.NOWHERE if fails else Mark.OPEN, share, clear)
    names, within = named_choices(holds, choices)
    return Marked(Mark.UNDER, share, clear, names, within)


def with_triples(
    found: Marked, holds: NDArray[np.bool_], certainty: NDArray[np.float64], readings: Mapping[str, NDArray[np.bool_]]
) -> Marked:
    """Return the mark of a claim that was also tried under readings that were selected afterwards.

    They do not count in its shares; but where nothing else makes it hold, one of them may.

    Args:
        found: the mark without them.
        holds: (specifications,) whether the claim holds under each.
        certainty: as in `marked`.
        readings: (specifications,) by name of a reading, whether each specification has it.
    """
    clearly = holds & (np.nan_to_num(certainty) >= CLEAR)
    if found.mark not in (Mark.NOWHERE, Mark.OPEN) or not clearly.any():
        return found
    share, name = max((float(holds[made].mean()), name) for name, made in readings.items() if clearly[made].any())
    return replace(found, mark=Mark.UNDER, choices=(name,), within=share)


def named_choices(holds: NDArray[np.bool_], choices: Mapping[str, NDArray[np.bool_]]) -> tuple[tuple[str, ...], float]:
    """Return the choices under which a claim holds, and the share of the specifications with them under which it does.

    As few choices as make it hold mostly, among them those that most specifications have; the single choice under which
    it holds most often if no two are enough.
    """
    for size in range(1, _MOST_NAMED + 1):
        found = [each for each in _within(holds, choices, size) if each[0] >= MOSTLY]
        if found:
            share, _, names = max(found, key=lambda each: each[1])
            return names, share
    share, _, names = max(_within(holds, choices, 1), default=(float("nan"), 0, ()))
    return names, share


def _within(
    holds: NDArray[np.bool_], choices: Mapping[str, NDArray[np.bool_]], size: int
) -> Sequence[tuple[float, int, tuple[str, ...]]]:
    """Return the share under which a claim holds, and the number of specifications, for each set of choices."""
    found = []
    for names in combinations(choices, size):
        made = np.logical_and.reduce([choices[name] for name in names])
        if (number := int(made.sum())) >= _FEWEST and number < len(made):
            found.append((float(holds[made].mean()), number, names))
    return found
