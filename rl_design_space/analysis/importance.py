"""Importance: how much of the variance between points is due to each choice, and to pairs of them.

A factorial of cell means μ has the functional analysis of variance (Sobol, Math. Comput. Simulation 55, 2001): with all
levels equally likely, the variance of E[μ | choices] is what these choices explain. Here every variance is freed of
what chance adds to it: an estimated mean contributes its own error.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.resampling import Estimate, percentile_interval, resampled_means

#: Bootstrap samples of periods for the intervals of shares.
RESAMPLES = 1000
#: Joins the names of a pair of choices.
PAIR = " × "

_Names = tuple[str, ...]


@dataclass(frozen=True)
class Cells:
    """Means of a factorial, and what chance does to them.

    Attributes:
        names: of the choices, in the order of the axes.
        means: (levels of the first choice, levels of the second, …)
        samples: (resamples, levels of the first choice, …) means of resampled periods, the same periods in all cells.
        values: (periods, levels of the first choice, …) of which the cells are means; None if they are means of none,
            such as medians.
    """

    names: _Names
    means: FloatArray
    samples: FloatArray
    values: FloatArray | None = None

    @classmethod
    def of_periods(cls, names: _Names, values: FloatArray, resamples: int = RESAMPLES, seed: int = 0) -> Cells:
        """Return the means of periods: (periods, levels of the first choice, levels of the second, …)."""
        flat = values.reshape(len(values), -1)
        samples = resampled_means(flat, seed, resamples).reshape(-1, *values.shape[1:])
        return cls(names, values.mean(axis=0, dtype=np.float64), samples, values)

    @property
    def size(self) -> int:
        """Number of cells."""
        return int(self.means.size)


@dataclass(frozen=True)
class Importance:
    """Share of the variance between cells that an effect explains.

    A share may be slightly negative, as its expected chance part has been subtracted. If the variance between cells
    cannot be told from 0, shares are those of the largest variance that the periods allow.

    Attributes:
        effect: name of a choice, or of two joined by ` × `: their interaction, without the effects of each.
        share: of the effect alone.
        total: with all interactions of the choice, of any order; NaN for pairs.
    """

    effect: str
    share: Estimate
    total: Estimate


@dataclass(frozen=True)
class Decomposition:
    """The variance between cells, and what explains it.

    Attributes:
        variance: between cell means, chance removed, with its interval.
        effects: of all choices and pairs, largest share first.
        rest: share of interactions of three or more choices.
    """

    variance: Estimate
    effects: tuple[Importance, ...]
    rest: Estimate

    @property
    def is_noise(self) -> bool:
        """Whether the variance cannot be told from 0, so that shares of it mean nothing."""
        return not self.variance.low > 0


def decomposed(parts: Sequence[Cells]) -> Decomposition:
    """Return the shares of the variance between cells by choices and pairs of choices.

    Args:
        parts: factorials with equally many samples. Several are weighted by their number of cells: the variance within
            factorials is what is explained, and a choice with one value in a factorial explains nothing there.
    """
    resamples = len(parts[0].samples)
    names = tuple(dict.fromkeys(name for part in parts for name in part.names))
    effects: list[_Names] = [
        effect
        for size in (1, 2)
        for effect in combinations(names, size)
        if any(set(effect) <= set(part.names) for part in parts)
    ]
    weights = np.array([part.size for part in parts], dtype=float)
    weights /= weights.sum()
    plain: dict[tuple[str, _Names], float] = {}
    drawn: dict[tuple[str, _Names], FloatArray] = {}
    for part, weight in zip(parts, weights, strict=True):
        explained = _explained(part)
        for key, (value, samples) in _components(part.names, effects, explained).items():
            plain[key] = plain.get(key, 0.0) + weight * value
            drawn[key] = drawn.get(key, np.zeros(resamples)) + weight * samples
    whole, whole_drawn = plain["all", ()], drawn["all", ()]

    def share(kind: str, effect: _Names) -> Estimate:
        return _ratio(plain[kind, effect], whole, drawn[kind, effect], whole_drawn)

    nothing = Estimate(np.nan, np.nan, np.nan)
    found = [
        Importance(PAIR.join(effect), share("own", effect), share("total", effect) if len(effect) == 1 else nothing)
        for effect in effects
    ]
    found.sort(key=lambda each: -each.share.value)
    low, high = percentile_interval(whole_drawn)
    return Decomposition(Estimate(whole, float(low), float(high)), tuple(found), share("rest", ()))


def _components(
    names: _Names, effects: Iterable[_Names], explained: Mapping[frozenset[str], tuple[float, FloatArray]]
) -> dict[tuple[str, _Names], tuple[float, FloatArray]]:
    """Return variances and their resamples by kind and effect; those of choices that do not differ here are 0."""
    whole, whole_drawn = explained[frozenset(names)]
    nothing = (0.0, np.zeros_like(whole_drawn))
    components: dict[tuple[str, _Names], tuple[float, FloatArray]] = {("all", ()): (whole, whole_drawn)}
    rest, rest_drawn = whole, whole_drawn
    for effect in effects:
        if not set(effect) <= set(names):
            components["own", effect] = nothing
        else:
            own, own_drawn = explained[frozenset(effect)]
            for name in effect if len(effect) > 1 else ():
                own, own_drawn = own - explained[frozenset([name])][0], own_drawn - explained[frozenset([name])][1]
            components["own", effect] = own, own_drawn
            rest, rest_drawn = rest - own, rest_drawn - own_drawn
        if len(effect) == 1:
            others, others_drawn = explained.get(frozenset(names) - set(effect), nothing)
            inside = effect[0] in names
            components["total", effect] = (whole - others, whole_drawn - others_drawn) if inside else nothing
    components["rest", ()] = rest, rest_drawn
    return components


def _explained(cells: Cells) -> dict[frozenset[str], tuple[float, FloatArray]]:
    """Return the variances that sets of choices explain, with bootstrap samples."""
    sets = {frozenset(keep) for size in (1, 2) for keep in combinations(cells.names, size)}
    sets |= {frozenset(cells.names), *(frozenset(cells.names) - {name} for name in cells.names)}
    found = {}
    for which in filter(None, sets):
        keep = tuple(name for name in cells.names if name in which)
        chance = _chance(cells, keep)
        plain = float((_projected(cells.means[np.newaxis], cells.names, keep) ** 2).mean())
        drawn = (_projected(cells.samples, cells.names, keep) ** 2).mean(axis=1, dtype=np.float64)
        # A resampled mean has twice the error of the mean itself.
        found[which] = plain - chance, drawn - 2 * chance
    return found


def _chance(cells: Cells, keep: _Names) -> float:
    """Return the variance that chance adds to what choices explain together."""
    if cells.values is None:
        return float(_projected(cells.samples, cells.names, keep).var(axis=0).mean(dtype=np.float64))
    periods = len(cells.values)
    each = _projected(cells.values, cells.names, keep)
    return float(each.var(axis=0, ddof=1, dtype=np.float64).mean() / periods) if periods > 1 else 0.0


def _projected(values: FloatArray, names: _Names, keep: _Names) -> FloatArray:
    """Return means over all choices but some, minus the mean over all of them: (first axis, combinations of those)."""
    over = tuple(axis for axis, name in enumerate(names, start=1) if name not in keep)
    kept: FloatArray = values.mean(axis=over) if over else values
    kept = kept.reshape(len(kept), -1)
    return np.asarray(kept - kept.mean(axis=1, keepdims=True))


def _ratio(part: float, whole: float, parts: FloatArray, wholes: FloatArray) -> Estimate:
    """Return a share; that of the largest variance that the periods allow, if the variance cannot be told from 0."""
    least, most = np.percentile(wholes, (2.5, 97.5))
    if not (whole > 0 and least > 0):
        wholes, whole = np.full_like(wholes, most), float(most)
    if not whole > 0:
        return Estimate(0.0, 0.0, 0.0)
    low, high = percentile_interval(parts / np.maximum(wholes, whole / 100))
    return Estimate(part / whole, float(low), float(high))
