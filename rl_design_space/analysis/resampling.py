"""Bootstrap samples of periods, and intervals from them; needs NumPy alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray

RESAMPLES = 5000
#: Weights that are held in memory at once.
AT_ONCE = 4_000_000


class Estimate(NamedTuple):
    """A value and its 95 % interval."""

    value: float
    low: float
    high: float


@lru_cache(maxsize=4)
def resample_weights(periods: int, seed: int = 0, resamples: int = RESAMPLES) -> FloatArray:
    """Return the weight of each period in each bootstrap resample.

    A weighted sum over periods is a resampled mean: `weights @ values`, for many columns of values at a time. Points of
    equal size and seed have the same layouts, so their differences are paired: the same weights resample both. Of many
    periods they take gigabytes, see `Resamples`.

    Returns:
        (resamples, periods), each row sums to 1.
    """
    rng, equal = np.random.default_rng(seed), np.full(periods, 1 / periods)
    weights = np.empty((resamples, periods))
    for rows in _blocks(resamples, periods):  # all counts at once would be as much memory again
        weights[rows] = rng.multinomial(periods, equal, size=rows.stop - rows.start)
    weights /= periods
    weights.setflags(write=False)  # cached, so it is shared
    return weights


@lru_cache(maxsize=3)
def _counts(periods: int, seed: int, resamples: int) -> NDArray[np.uint8]:
    """Return how often each period is drawn in each resample, which takes an eighth of the memory of its weight."""
    rng, equal = np.random.default_rng(seed), np.full(periods, 1 / periods)
    counts = np.empty((resamples, periods), np.uint8)
    for rows in _blocks(resamples, periods):
        # More than 255 times is as likely as a period in 10^500.
        counts[rows] = rng.multinomial(periods, equal, size=rows.stop - rows.start)
    counts.setflags(write=False)  # cached, so it is shared
    return counts


@dataclass(frozen=True)
class Resamples:
    """Bootstrap resamples of periods, which yield their weights some at a time, so that memory is bounded.

    Attributes:
        periods: their number.
        seed: of the resampling.
        resamples: their number.
        of: the periods that are resampled, the even ones, for example; the others have the weight 0.
    """

    periods: int
    seed: int = 0
    resamples: int = RESAMPLES
    of: slice = field(default_factory=lambda: slice(None), hash=False)

    @property
    def shape(self) -> tuple[int, int]:
        """Of the weights: (resamples, periods)."""
        return self.resamples, self.periods

    def blocks(self) -> Iterator[FloatArray]:
        """Yield weights as `resample_weights` returns them, (some resamples, periods), in blocks of 32 MB at most."""
        chosen = np.arange(self.periods)[self.of]
        if not len(chosen):
            return
        if self.resamples * self.periods <= AT_ONCE:
            yield _weights(self.periods, self.seed, self.resamples, (self.of.start, self.of.stop, self.of.step))
            return
        if self.resamples * len(chosen) <= AT_ONCE:
            yield _of_all(self.periods, resample_weights(len(chosen), self.seed, self.resamples), chosen)
            return
        counts = _counts(len(chosen), self.seed, self.resamples)
        for rows in _blocks(*self.shape):
            yield _of_all(self.periods, counts[rows] / len(chosen), chosen)


@lru_cache(maxsize=2)
def _weights(periods: int, seed: int, resamples: int, of: tuple[int | None, int | None, int | None]) -> FloatArray:
    """Return the weights of all periods in resamples of some of them; hundreds of measures share them."""
    chosen = np.arange(periods)[slice(*of)]
    every = _of_all(periods, resample_weights(len(chosen), seed, resamples), chosen)
    every.setflags(write=False)  # cached, so it is shared
    return every


def _of_all(periods: int, weights: FloatArray, chosen: NDArray[np.intp]) -> FloatArray:
    """Return the weights of all periods from those of the chosen ones."""
    if len(chosen) == periods:
        return weights
    every = np.zeros((len(weights), periods))
    every[:, chosen] = weights
    return every


def _blocks(resamples: int, periods: int) -> Iterator[slice]:
    rows = max(1, AT_ONCE // periods)
    return (slice(start, min(start + rows, resamples)) for start in range(0, resamples, rows))


def resampled_means(values: NDArray[Any], seed: int = 0, resamples: int = RESAMPLES) -> NDArray[Any]:
    """Return the means of the periods in each bootstrap resample, (resamples, …), in the precision of the values.

    Args:
        values: (periods, …)
        seed: of the resampling.
        resamples: their number.
    """
    kind = values.dtype if values.dtype.kind == "f" else np.dtype(np.float64)
    blocks = Resamples(len(values), seed, resamples).blocks()
    return np.concatenate([block.astype(kind, copy=False) @ values for block in blocks])


def percentile_interval(samples: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the ends of the middle 95 % of bootstrap samples, along the first axis."""
    low, high = np.percentile(samples, (2.5, 97.5), axis=0)
    return low, high
