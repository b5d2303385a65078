"""The runs that a report shows, whether they were found by the plan of a study or by a search of the store."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from rl_design_space._ahead import ahead
from rl_design_space._arrays import FloatArray
from rl_design_space._markdown import code
from rl_design_space.analysis.averaging import estimate, mean_of_runs, pooled
from rl_design_space.analysis.censoring import Bounded
from rl_design_space.config.measure_name import measure_of
from rl_design_space.config.overrides import with_absent
from rl_design_space.config.recorded import recorded_point
from rl_design_space.design import from_scratch
from rl_design_space.errors import ConfigError
from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.fingerprint import fingerprint
from rl_design_space.report.chosen_points import ChosenPoints
from rl_design_space.report.ordering import Ordering
from rl_design_space.report.parameters import PERIODS, text
from rl_design_space.report.points import (
    Point,
    by_design,
    different_choices,
    other_samples,
    points_of_frame,
    repetition,
    with_defaults,
)
from rl_design_space.report.results import Results
from rl_design_space.report.watching import Watch, unwatched
from rl_design_space.run.enough import enough_text

if TYPE_CHECKING:
    from rl_design_space.design import DesignPoint
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.reader import Reader

#: Numbers of periods that are listed; of more, the first and the last.
_LISTED = 4
#: Stands for the number of runs in a text.
_RUNS = "\0"


class Runs(ChosenPoints):
    """Design points and their results; each result is read once.

    Args:
        points: in any order.
        reader: of the tracking store.
        name: what the points are called in messages.
        made_by: paragraph that says where the report comes from; `_RUNS` in it stands for the number of runs used.
        remarks: more paragraphs, such as how many points are missing.
        mark: short note for the corner of a picture.
    """

    def __init__(
        self,
        points: Iterable[Point],
        reader: Reader,
        name: str = "these runs",
        made_by: str = "",
        remarks: Sequence[str] = (),
        mark: str = "",
    ) -> None:
        super().__init__(points, name)
        self.remarks, self.mark = remarks, mark
        self._made_by = made_by
        self._reader = reader
        self._results = Results(reader)
        #: Points whose results were asked for.
        self._used: set[Point] = set()
        #: Iterates over items, and shows how far it is.
        self.watch: Watch = unwatched

    @classmethod
    def of_study(cls, study: Study, reader: Reader) -> Runs:
        """Return the points of a study, recorded or not, in the order of its plan."""
        runs = reader.finished([planned.fingerprint for planned in study.plan])
        planned_points = [Point.planned_with(planned, runs.get(planned.fingerprint)) for planned in study.plan]
        parameters = with_absent([point.parameters for point in planned_points])
        points = [point.with_parameters(each) for point, each in zip(planned_points, parameters, strict=True)]
        points = with_defaults(points)
        made_by, remarks = f"Made by {code(study.report_command)}, which needs no runs.", []
        if points:
            periods = _joined({point.parameters[PERIODS] for point in points})
            made_by = (
                f"Made by {code(study.report_command)} from runs of {code(study.command)}, {periods} periods a point."
            )
        if missing := sum(point.run is None for point in points):
            remarks = [f"**Missing: {missing} of {len(points)} points**; {code(study.command)} makes them."]
        if enough := enough_text(study.plan, runs):
            remarks.append(f"{enough[0].upper()}{enough[1:]}.")
        found = cls(points, reader, study.plan.name, made_by, remarks, study.mark)
        values: dict[str, dict[Any, None]] = {}
        for point in points:
            for parameter, value in point.parameters.items():
                values.setdefault(parameter, {})[value] = None
        found.ordering = Ordering.of_study(values)
        return found

    @classmethod
    def of_frame(
        cls,
        frame: pd.DataFrame,
        reader: Reader,
        command: str,
        remarks: Sequence[str] = (),
        *,
        every: bool = False,
        listed: Mapping[str, Iterable[Any]] = MappingProxyType({}),
        asked: Sequence[str] = (),
    ) -> Runs:
        """Return runs that were found in the store.

        Of a point with several numbers of periods, the longest run counts, because it has the periods of the others.

        Args:
            frame: as `RunReader.frame` returns it.
            reader: of the same store.
            command: command line that makes the report.
            remarks: paragraphs, such as which runs were left out.
            every: whether all runs of such a point count.
            listed: values of each parameter in the order of the study that they are of.
            asked: texts in which names of parameters may stand that all runs leave out.

        Raises:
            ConfigError: there is no run.
        """
        if frame.empty:
            raise ConfigError("no run was selected; `rl-design-space store status` says what is recorded")
        points = with_defaults(points_of_frame(frame, every=every), asked)
        if fewer := frame["fingerprint"].nunique() - len(points):
            remarks = [*remarks, f"Left out: {fewer} runs with fewer periods of the same points."]
        periods = _joined({point.parameters[PERIODS] for point in points})
        made_by = f"Made by {code(command)} from {_RUNS}, {periods} periods a point."
        found = cls(points, reader, made_by=made_by, remarks=remarks)
        found.ordering = Ordering.of_study(listed)
        return found

    @property
    def made_by(self) -> str:
        """Paragraph that says where the report comes from; call it after the report has read what it shows."""
        used, found = len(self._used), len(self.points)
        number = f"{used} of {found} runs" if used < found else "1 run" if found == 1 else f"{found} runs"
        return self._made_by.replace(_RUNS, number)

    @property
    def recorded(self) -> list[Point]:
        """The points that have a run."""
        return [point for point in self.points if point.run]

    @property
    def in_flight(self) -> int:
        """Number of points whose results are best read at the same time."""
        return self._reader.in_flight

    def with_larger(self, larger: Runs, command: str) -> Runs:
        """Return these runs and larger samples of their designs, which a command line makes, see `points.largest`."""
        runs = copy(self)
        parameters = with_absent([point.parameters for point in (*self.points, *larger.points)])
        of_larger = zip(larger.points, parameters[len(self.points) :], strict=True)
        points = with_defaults([*self.points, *(point.with_parameters(each) for point, each in of_larger)])
        before, after = points[: len(self.points)], points[len(self.points) :]
        more = other_samples(after, before)
        runs.points = [*before, *more]
        if recorded := sum(point.run is not None for point in more):
            runs._made_by = f"{self._made_by} Larger samples of {recorded} points are from runs of {code(command)}."
        runs.remarks = [*self.remarks, *(larger.remarks if recorded < len(more) else [])]
        return runs

    def kept(self, point: Point) -> LearningCurves | None:
        """Return the result of a point; None if it has no run, or its run did not keep its periods."""
        self._used.add(point)
        return self._results.of(point)

    def design_point(self, point: Point) -> DesignPoint:
        """Return the design point of a recorded point, from the plan of its study or from the config of its run.

        Raises:
            ConfigError: the config of the run is not accepted.
        """
        if point.of_plan:
            return point.of_plan.point
        assert point.run is not None
        return recorded_point(self._reader.config(point.run), f"run {point.run.run_id}")

    def forget(self, point: Point) -> None:
        """Free the memory of a result that is not needed again."""
        self._results.forget(point)

    def result(self, point: Point) -> LearningCurves | None:
        """Return the result of a point; None if it has no run.

        Raises:
            ConfigError: its run did not keep its periods.
        """
        result = self.kept(point)
        if point.run and result is None:
            command = f" of `{point.of_plan.command}`" if point.of_plan else ""
            raise ConfigError(
                f"tracking.artifact=curves: the run{command} kept its learning curves alone; this report needs runs "
                "that were recorded with tracking.artifact=periods"
            )
        return result

    def pooled(self, seeds: Sequence[Point]) -> LearningCurves | None:
        """Return the periods of all seeds of one design as one result; None if one of them has no run.

        Raises:
            ConfigError: the points differ in more than their seed, or a run did not keep its periods.
        """
        if others := different_choices(seeds):
            raise ConfigError(
                f"{', '.join(others)}: {len(seeds)} points of {self._name} differ in this; should be one point"
            )
        results = [result for point in seeds if (result := self.result(point))]
        return pooled(results) if results and len(results) == len(seeds) else None

    def from_scratch(self, seeds: Sequence[Point]) -> LearningCurves | None:
        """Return the result of the same stages with nothing carried; None if one of the seeds is not recorded so.

        Raises:
            ConfigError: the config of a run is not accepted.
        """
        points = [from_scratch(self.design_point(point)) for point in seeds]
        wanted = [fingerprint(point) for point in points]
        found = self._reader.finished(wanted)
        if any(each not in found for each in wanted):
            return None
        arrays = [self._reader.periods(found[each]) for each in wanted]
        if any("steps" not in each for each in arrays):
            return None
        return pooled([LearningCurves.of_arrays(*each) for each in zip(arrays, points, strict=True)])

    def curve(self, point: Point, name: str) -> FloatArray:
        """Return a learning curve of a recorded point, (trials,).

        Raises:
            ConfigError: there is no such curve.
        """
        self._used.add(point)
        if name not in (curves := self._results.curves(point)):
            raise ConfigError.unknown("learning curve", name, [each for each in curves if "/" in each])
        return curves[name]

    def values(self, point: Point, name: str) -> FloatArray | None:
        """Return what each period contributes to a scalar or measure, (periods,); None if that is not known.

        Raises:
            ConfigError: there is no such scalar or measure.
        """
        measured = measure_of(name)
        result = self.kept(point)
        if result is None or measured is None:
            return None
        values = measured.each(result)
        return None if values is None or np.isnan(values).any() else values

    def estimate(self, points: Sequence[Point], name: str) -> Bounded:
        """Return the mean of a scalar or measure over designs, with its interval where the periods are known.

        Raises:
            ConfigError: there is no such scalar or measure.
        """
        measured = measure_of(name)
        recorded = [point for point in points if point.run]
        repetitions = [repetition(point) for point in recorded]
        for _ in ahead(self.kept, recorded, self.in_flight):
            pass  # it is remembered
        known = [values for point in recorded if (values := self.values(point, name)) is not None]
        if known and len(known) == len(recorded):
            return Bounded(*mean_of_runs(known, repetitions, of_shares=bool(measured and measured.is_share)))
        results = [result for point in recorded if (result := self.kept(point))]
        if measured and results and len(results) == len(recorded) and measured.each(results[0]) is None:
            return estimate(measured, results, repetitions)
        numbers = [self._scalar(seeds, name) for seeds in by_design(recorded)]
        return Bounded(sum(numbers) / len(numbers) if numbers else math.nan, math.nan, math.nan)

    def _scalar(self, seeds: Sequence[Point], name: str) -> float:
        """Return a scalar of the seeds of one design: that of all their periods if they are known, else the mean."""
        results = [result for point in seeds if (result := self.kept(point))]
        if len(seeds) > 1 and len(results) == len(seeds) and name in (scalars := pooled(results).scalars()):
            return scalars[name]
        numbers = [point.run.scalars.get(name, float("nan")) for point in seeds if point.run]
        return sum(numbers) / len(numbers)


def _joined(numbers: Iterable[Any]) -> str:
    ordered = sorted(numbers)
    few = len(ordered) <= _LISTED
    return " or ".join(map(text, ordered)) if few else f"{text(ordered[0])} to {text(ordered[-1])}"
