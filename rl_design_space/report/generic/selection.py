"""The runs that a report is about, wherever they were found: in a study's plan, or in the store."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rl_design_space._arrays import FloatArray
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import ALIASES, MEASURES, SCALARS, measure, scaled_to_equal_steps
from rl_design_space.learning.result import LearningCurves
from rl_design_space.tracking.run_frame import ABOUT, typed
from rl_design_space.tracking.tracker import StoredRun
from rl_design_space.tracking.values import param

if TYPE_CHECKING:
    import pandas as pd

    from rl_design_space.analysis.statistics import Estimate
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.read import Reader

#: Runs that differ in this alone are repetitions of each other.
SEED = "seed"


@dataclass(frozen=True, eq=False)
class Point:
    """A design point.

    Attributes:
        parameters: every choice by its name; lists as text.
        run: its complete run, if it has one.
    """

    parameters: Mapping[str, Any]
    run: StoredRun | None

    def key(self, names: Iterable[str]) -> tuple[Any, ...]:
        """Its values of these parameters; None for those that it does not have."""
        return tuple(self.parameters.get(name) for name in names)


class Selection:
    """Design points and what was recorded of them; each run is read once.

    Args:
        points: in any order.
        reader: of the store.
        made_by: where the report comes from, a paragraph.
        remarks: more paragraphs, such as what is missing.
        mark: what a picture has to say of them all.
    """

    def __init__(
        self, points: Iterable[Point], reader: Reader, made_by: str, remarks: Sequence[str] = (), mark: str = ""
    ) -> None:
        self.points = list(points)
        self.made_by, self.remarks, self.mark = made_by, remarks, mark
        self._reader = reader
        self._periods: dict[Point, LearningCurves | None] = {}

    @classmethod
    def of_study(cls, study: Study, reader: Reader) -> Selection:
        """The points of a study, recorded or not."""
        from rl_design_space.report.markdown import made_by, missing_points

        runs = reader.finished([planned.fingerprint for planned in study.plan])
        points = [
            Point({name: typed(param(value)) for name, value in each.parameters.items()}, runs.get(each.fingerprint))
            for each in study.plan
        ]
        missing = missing_points(study, sum(point.run is None for point in points))
        return cls(points, reader, made_by(study), [line for line in missing if line], study.mark)

    @classmethod
    def of_runs(cls, frame: pd.DataFrame, reader: Reader, command: str, remarks: Sequence[str] = ()) -> Selection:
        """Runs of a store.

        Args:
            frame: as `RunReader.frame` returns it.
            reader: of the same store.
            command: that makes the report.
            remarks: more paragraphs, such as what was left out.

        Raises:
            ConfigError: there is no run.
        """
        import pandas as pd

        if frame.empty:
            raise ConfigError("no run was selected; `rl-design-space store status` says what is recorded")
        points = []
        for record in frame.drop_duplicates("fingerprint").reset_index().to_dict("records"):
            there = {str(name): value for name, value in record.items() if not pd.isna(value)}
            scalars = {name: there.pop(name) for name in SCALARS if name in there}
            run = StoredRun(record["run_id"], scalars=scalars, artifacts=record["artifacts"])
            points.append(Point({name: value for name, value in there.items() if name not in ABOUT}, run))
        periods = sorted({point.parameters["task.periods"] for point in points})
        runs = "1 run" if len(points) == 1 else f"{len(points)} runs"
        made_by = f"Made by `{command}` from {runs}, {' or '.join(map(text, periods))} periods a point."
        return cls(points, reader, made_by, remarks)

    @property
    def recorded(self) -> list[Point]:
        """The points that have a run."""
        return [point for point in self.points if point.run]

    def check(self, names: Iterable[str]) -> None:
        """Refuse names of parameters that no point has.

        Raises:
            ConfigError: there is one; the nearest right one is named.
        """
        known = {name for point in self.points for name in point.parameters}
        for name in names:
            if name not in known:
                raise ConfigError.unknown("parameter of these runs", name, known)

    def grouped(
        self, names: Sequence[str], points: Iterable[Point] | None = None
    ) -> dict[tuple[Any, ...], list[Point]]:
        """Points by their values of parameters, in the order of these.

        Raises:
            ConfigError: no point has a parameter of such a name.
        """
        self.check(names)
        groups: dict[tuple[Any, ...], list[Point]] = {}
        for point in self.points if points is None else points:
            groups.setdefault(point.key(names), []).append(point)
        return dict(sorted(groups.items(), key=lambda group: [order(value) for value in group[0]]))

    def periods(self, point: Point) -> LearningCurves | None:
        """What was recorded of a point; None if its run did not keep its periods, or it has none."""
        if point not in self._periods:
            arrays = self._reader.periods(point.run) if point.run else {}
            self._periods[point] = LearningCurves.of_arrays(arrays) if "steps" in arrays else None
        return self._periods[point]

    def curve(self, point: Point, name: str) -> FloatArray:
        """(trials,) a learning curve of a recorded point.

        Raises:
            ConfigError: there is no such curve.
        """
        arrays = self._reader.periods(point.run) if point.run else {}
        if name not in arrays or arrays[name].ndim != 1:
            raise ConfigError.unknown("learning curve", name, [each for each in arrays if "/" in each])
        curve: FloatArray = arrays[name]
        return curve

    def values(self, point: Point, name: str) -> FloatArray | None:
        """(periods,) what each period contributes to a scalar; None if nothing can be said of the periods.

        Raises:
            ConfigError: there is no such scalar.
        """
        known = dict.fromkeys((*SCALARS, *MEASURES, *ALIASES))
        if name not in known:
            raise ConfigError.unknown("scalar or measure", name, known)
        recorded = self.periods(point)
        if recorded is None or name not in (*MEASURES, *ALIASES):
            return None
        if name == "total_steps_scaled":  # of a run, the parameters are known, the point is not built
            side = point.parameters["world.size"]
            return scaled_to_equal_steps(recorded.total_steps, side) if isinstance(side, int | float) else None
        return measure(name).each(recorded)

    def estimate(self, points: Sequence[Point], name: str) -> Estimate:
        """Mean of a scalar over runs, with its interval where the periods are known.

        Raises:
            ConfigError: there is no such scalar.
        """
        from rl_design_space.analysis.averaging import estimate, mean_of_runs
        from rl_design_space.analysis.statistics import Estimate

        runs = [point for point in points if point.run]
        strata = [stratum(point) for point in runs]
        values = [self.values(point, name) for point in runs]
        known = [value for value in values if value is not None]
        if known and len(known) == len(runs):
            return mean_of_runs(known, strata)
        results = [result for point in runs if (result := self.periods(point))]
        if results and len(results) == len(runs) and name in MEASURES:
            return estimate(MEASURES[name], results, strata)
        numbers = [point.run.scalars.get(name, float("nan")) for point in runs if point.run]
        mean = sum(numbers) / len(numbers) if numbers else float("nan")
        return Estimate(mean, float("nan"), float("nan"))


def stratum(point: Point) -> Hashable:
    """What points have in common whose periods met the same random numbers: their periods are resampled together."""
    return point.key((SEED, "task.periods"))


def check_averaged(points: Sequence[Point], where: str, advice: str, mean: bool) -> None:
    """Refuse to average runs that differ in more than their seed, unless that is asked for.

    Args:
        points: of one cell, line or the like.
        where: which one, for people.
        advice: what else the user can do.
        mean: whether it is asked for.

    Raises:
        ConfigError: they differ; the parameters are named.
    """
    from rl_design_space.analysis.averaging import differing

    others = [name for name in differing([point.parameters for point in points]) if name != SEED]
    if others and not mean:
        raise ConfigError(
            f"{', '.join(others)}: {len(points)} runs of one {where} differ in this; {advice}, choose with --filter, "
            "or take their mean with --mean"
        )


def text(value: Any) -> str:
    """A value of a parameter as one reads it."""
    if value is None:
        return "–"
    return f"{value:g}" if isinstance(value, float) else str(value)


def label(names: Collection[str], values: Iterable[Any]) -> str:
    """Values of parameters as one would type them."""
    return " ".join(f"{name}={text(value)}" for name, value in zip(names, values, strict=True))


def order(value: Any) -> tuple[int, float, str]:
    """What values of parameters are sorted by: numbers by their size, then texts, then what is not there."""
    if value is None:
        return (2, 0.0, "")
    return (0, float(value), "") if isinstance(value, int | float) else (1, 0.0, str(value))
