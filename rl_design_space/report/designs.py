"""Designs with the periods that all of them have, so that every number of one has its counterpart in the others."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import chain, islice
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator

from rl_design_space._ahead import ahead
from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.averaging import pooled
from rl_design_space.analysis.columns import Columns
from rl_design_space.analysis.factorial import Grids, grids
from rl_design_space.analysis.scales import SCALES
from rl_design_space.analysis.statistics import resample_weights
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import canonical, measure
from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.differences import differing
from rl_design_space.report.parameters import PERIODS, SEED, label, order, text
from rl_design_space.report.points import Point
from rl_design_space.report.runs import Runs
from rl_design_space.tracking.values import param

#: Arrays of a result that have a row for each period.
_OF_PERIODS = ("steps", "success", "optimum", "rows")
#: A field that names a scale, see `analysis.scales`, or a measure.
ScaleName = Annotated[
    str,
    BeforeValidator(
        lambda spec: spec if isinstance(spec, str) and spec in SCALES else canonical(spec),
        json_schema_input_type=str | dict[str, Any],
    ),
]
#: Fewest periods that resampling makes sense of.
_FEWEST = 2


@dataclass(frozen=True)
class Numbers:
    """A number of each design, and what chance does to it.

    Attributes:
        value: (designs,)
        samples: (resamples, designs) numbers of resampled periods, the same periods in all designs.
        each: (periods, designs) of which the numbers are means; None if they are means of none.
    """

    value: FloatArray
    samples: FloatArray
    each: FloatArray | None


@dataclass(frozen=True)
class OwnNumbers:
    """A number of each design over all its periods, of which some designs have more than others.

    Attributes:
        value: (designs,)
        samples: (resamples, designs) numbers of resampled periods, the same in all designs that have the same periods.
        each: of which the numbers are means.
    """

    value: FloatArray
    samples: FloatArray
    each: Columns


class Designs:
    """Designs, points that differ in more than seed and number of periods, and their common periods.

    Args:
        runs: what was recorded; of several numbers of periods of one seed, the largest counts.
        points: which of them; all that are recorded if None.

    Raises:
        ConfigError: designs have no two periods in common.
    """

    def __init__(self, runs: Runs, points: Sequence[Point] | None = None) -> None:
        self._runs = runs
        found: dict[Hashable, dict[Any, Point]] = {}
        for point in runs.recorded if points is None else points:
            name = tuple(sorted((key, value) for key, value in point.parameters.items() if key not in (SEED, PERIODS)))
            seeds = found.setdefault(name, {})
            seed = point.parameters.get(SEED)
            if seed not in seeds or _periods(seeds[seed]) < _periods(point):
                seeds[seed] = point
        self._points = list(found.values())
        if not self._points:
            raise ConfigError("no run was selected; `rl-design-space store status` says what is recorded")
        #: Values of all parameters of each design.
        self.parameters: list[Mapping[str, Any]] = [
            {key: value for key, value in next(iter(seeds.values())).parameters.items() if key not in (SEED, PERIODS)}
            for seeds in self._points
        ]
        common = set.intersection(*(set(seeds) for seeds in self._points))
        #: Number of periods of each seed that all designs have.
        self.seeds = {seed: min(_periods(each[seed]) for each in self._points) for seed in sorted(common, key=order)}
        if self.periods < _FEWEST:
            raise ConfigError(
                f"{SEED}: {len(self._points)} designs have {self.periods or 'no'} periods in common, by which they "
                "could be paired; run all of them with the same seeds, and at least two periods"
            )

    def __len__(self) -> int:
        return len(self._points)

    @property
    def periods(self) -> int:
        """Number of periods that all designs have, those of all seeds together."""
        return sum(self.seeds.values())

    @property
    def names(self) -> list[str]:
        """Parameters in which the designs differ, those of one choice together."""
        names = differing(self.parameters)
        choices = [name.partition(".")[0] for name in names]
        return sorted(names, key=lambda name: choices.index(name.partition(".")[0]))

    @property
    def trials(self) -> int:
        """Number of trials of a period; the smallest if there are several."""
        return min(int(parameters["task.trials"]) for parameters in self.parameters)

    def sorted(self) -> Designs:
        """Return these designs in the order of the values of their parameters."""
        names = self.names
        keys = [self._runs.ordering.keys(names, map(each.get, names)) for each in self.parameters]
        ranks = sorted(range(len(self)), key=keys.__getitem__)
        self._points = [self._points[rank] for rank in ranks]
        self.parameters = [self.parameters[rank] for rank in ranks]
        return self

    @property
    def most_periods(self) -> int:
        """Largest number of periods of a design, those of the seeds together that all designs have."""
        return max(sum(_periods(each[seed]) for seed in self.seeds) for each in self._points)

    def remarks(self, *, own: bool = False) -> list[str]:
        """Return which periods count, as sentences.

        Args:
            own: whether each design counts with all its periods, see `of_own_periods`.
        """
        seeds = f" of {len(self.seeds)} seeds" if len(self.seeds) > 1 else ""
        if own:
            span = f"{self.periods:,} to {self.most_periods:,} periods{seeds}"
            return [f"{len(self):,} designs of {span}, each two paired by the periods that both have."]
        parts = [f"{len(self):,} designs, paired by the {self.periods:,} periods{seeds} that all of them have."]
        if self.most_periods > self.periods:
            parts.append(f"Some have up to {self.most_periods:,} periods; those that others do not have are left out.")
        return [" ".join(parts)]

    def grids(self) -> Grids:
        """Return the factorials that the designs consist of.

        Raises:
            ConfigError: there is one design only, or no two are equal in all choices but one.
        """
        if not (names := self.names):
            raise ConfigError("these runs differ in nothing but their seed and number of periods; choose more runs")
        return grids(self.parameters, names)

    def results(self, what: str = "reading runs") -> Iterator[LearningCurves]:
        """Yield the result of each design: its common periods, one seed after the other.

        Raises:
            ConfigError: a run did not keep its periods.
        """
        for parts in self._whole_results(what):
            yield pooled([_first(part, periods) for part, periods in zip(parts, self.seeds.values(), strict=True)])

    def _whole_results(self, what: str) -> Iterator[list[LearningCurves]]:
        """Yield the results of each design, one for each seed."""
        found = ahead(self._result, [each[seed] for each in self._points for seed in self.seeds], self._runs.in_flight)
        for _ in self._runs.watch(self._points, what):
            yield list(islice(found, len(self.seeds)))

    def _result(self, point: Point) -> LearningCurves:
        result = self._runs.result(point)
        assert result is not None  # of a recorded point
        self._runs.forget(point)
        return result

    def numbers(
        self, name: str, resamples: int, also: Callable[[LearningCurves], FloatArray] | None = None
    ) -> tuple[Numbers, list[FloatArray]]:
        """Return a scale or measure of each design, and another number of each that is computed on the way.

        Args:
            name: of the scale or measure.
            resamples: number of bootstrap samples.
            also: the other number.

        Raises:
            ConfigError: the measure cannot be computed.
        """
        measured = None if name in SCALES else measure(name)
        weights = resample_weights(self.periods, 0, resamples)
        equal = np.full((1, self.periods), 1 / self.periods)
        each, values, samples, more = [], [], [], []
        for result in self.results():
            numbers = SCALES[name].each(result) if measured is None else measured.each(result)
            if numbers is not None:
                each.append(numbers)
            elif measured is not None:
                values.append(measured.samples(result, equal))
                samples.append(measured.samples(result, weights))
            if also:
                more.append(also(result))
        if each:
            every = np.stack(each, axis=1)
            columns = Columns.of_array(every)
            value = every.mean(axis=0) if columns.is_even else columns.means
            return Numbers(value, _samples(columns, lambda size: resample_weights(size, 0, resamples)), every), more
        return Numbers(np.concatenate(values), np.stack(samples, axis=1), None), more

    def of_own_periods(self, name: str, resamples: int) -> OwnNumbers | None:
        """Return a measure of each design over all its periods.

        None if all designs have the same number, or the measure is no mean of periods.
        """
        if self.most_periods == self.periods:
            return None
        measured = measure(name)
        read = ([measured.each(part) for part in parts] for parts in self._whole_results("reading runs"))
        first = next(read)
        if any(numbers is None for numbers in first):
            return None
        starts = np.cumsum([0, *(max(_periods(each[seed]) for each in self._points) for seed in self.seeds)])
        sizes = {sum(_periods(each[seed]) for seed in self.seeds) for each in self._points}
        with ThreadPoolExecutor(1) as pool:  # weights of 20,000 periods take as long as a thousand files
            drawn = {size: pool.submit(resample_weights, size, 0, resamples) for size in sorted(sizes, reverse=True)}
            each = Columns.of_designs((_known(parts, starts) for parts in chain([first], read)), int(starts[-1]))
            samples = _samples(
                each, lambda size: drawn[size].result() if size in drawn else resample_weights(size, 0, resamples)
            )
        return OwnNumbers(each.means, samples, each)


def chosen(runs: Runs, given: Mapping[str, Any]) -> list[Point]:
    """Return the recorded points that have these values.

    Raises:
        ConfigError: there is none, or no point has a parameter of such a name.
    """
    runs.check_values(given)
    found = [point for point in runs.recorded if point.has(given)]
    if not found:
        wanted = " ".join(f"{name}={param(value)}" for name, value in given.items())
        raise ConfigError(f"{wanted or 'these runs'}: no recorded run has these values")
    return found


def given_label(given: Mapping[str, Any]) -> str:
    """Return what is given as the end of a heading; empty if nothing is."""
    values = [",".join(map(text, value)) if isinstance(value, list) else value for value in given.values()]
    return f", given {label(given, values)}" if given else ""


def _samples(each: Columns, weights: Callable[[int], FloatArray]) -> FloatArray:
    """Return (resamples, designs) means of resampled periods, the same in all designs that have the same.

    Args:
        each: numbers of the periods.
        weights: returns (resamples, periods) the weights of so many periods.
    """
    parts = [weights(len(block.rows)) @ block.numbers for block in each.blocks]
    return np.concatenate(parts, axis=1)[:, np.argsort(np.concatenate([block.designs for block in each.blocks]))]


def _known(numbers: Sequence[FloatArray | None], starts: NDArray[np.intp]) -> tuple[NDArray[np.intp], FloatArray]:
    """Return the periods of a design whose number is known, and their numbers.

    Args:
        numbers: of each seed.
        starts: first period of each seed.
    """
    parts = [part for part in numbers if part is not None]
    every = np.concatenate(parts)
    rows = np.concatenate([start + np.arange(len(part)) for part, start in zip(parts, starts, strict=False)])
    known = ~np.isnan(every)
    return rows[known], every[known]


def _first(result: LearningCurves, periods: int) -> LearningCurves:
    """Return the result of the first periods."""
    cut: dict[str, Any] = {name: getattr(result, name)[:periods] for name in _OF_PERIODS}
    return replace(result, **cut)


def _periods(point: Point) -> int:
    return int(point.parameters[PERIODS])
