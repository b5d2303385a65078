"""What the result of a point says of each of its stages."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray, Optimum

#: Name of the learning curve that says of each trial in which stage it is.
STAGE_CURVE = "stage"
#: Prefix of the names of arrays in a file.
_FILED = "stages:"
#: The scalar that is that of the whole point: time is not measured stage by stage.
_OF_ALL = "env_steps_per_second"
#: Names of the scalars of stages, such as `stage2/total_steps`.
_SCALAR = re.compile(r"stage[1-9]\d*/\w+")


class StageRecord(NamedTuple):
    """A stage in the result of a point.

    Attributes:
        trials: number of its trials.
        side: cells along each side of its grid; NaN if it is not square.
        optimum: (periods,) int32, fewest steps possible.
        rows: (periods, 2) int32, see `LearningCurves`.
        carried: (periods,) int32, rows that have begun with values of earlier stages.
    """

    trials: int
    side: float
    optimum: Optimum
    rows: NDArray[np.int32]
    carried: NDArray[np.int32]

    def scalars(self) -> dict[str, float]:
        """Return what is recorded of the stage beside the numbers of any result."""
        return {"optimum": float(self.optimum.mean()), "carried": float((self.carried / self.rows[:, 0]).mean())}

    def of_periods(self, some: Any) -> StageRecord:
        """Return the record of some of the periods."""
        return self._replace(optimum=self.optimum[some], rows=self.rows[some], carried=self.carried[some])


Records = Sequence[StageRecord]


def bounds(stages: Records) -> list[slice]:
    """Return the trials of each stage."""
    ends = np.cumsum([stage.trials for stage in stages]).tolist()
    return [slice(end - stage.trials, end) for end, stage in zip(ends, stages, strict=True)]


def by_trial(stages: Records, values: Sequence[Any]) -> NDArray[Any]:
    """Return a value of each stage, a number or one of each period, by trial: (…, trials)."""
    return np.repeat(np.stack(values, axis=-1), [stage.trials for stage in stages], axis=-1)


def stage_curve(stages: Records) -> FloatArray:
    """Return (trials,) the number of the stage of each trial, from 1."""
    return by_trial(stages, range(1, 1 + len(stages))).astype(np.float64)


def stage_scalars(stages: Records, scalars_of: Callable[[int], Mapping[str, float]]) -> dict[str, float]:
    """Return the scalars of all stages, as they are recorded.

    Args:
        stages: the stages.
        scalars_of: those of a stage alone, by its number.
    """
    return {
        f"stage{number}/{name}": value
        for number, stage in enumerate(stages, 1)
        for name, value in {**scalars_of(number), **stage.scalars()}.items()
        if name != _OF_ALL
    }


def is_scalar_name(name: str) -> bool:
    """Return whether a metric is a scalar of a stage."""
    return _SCALAR.fullmatch(name) is not None


def combined(
    results: Sequence[Records], combine: Callable[[list[NDArray[Any]]], NDArray[Any]] = np.concatenate
) -> tuple[StageRecord, ...]:
    """Return the stages of the periods of several results together; none unless their stages have the same trials.

    Args:
        results: stages of each result.
        combine: makes one array of arrays of periods.
    """
    if len({tuple(stage.trials for stage in stages) for stages in results}) != 1:
        return ()
    return tuple(
        StageRecord(
            *each[0][:2], *(combine(list(arrays)) for arrays in zip(*(stage[2:] for stage in each), strict=True))
        )
        for each in zip(*results, strict=True)
    )


def filed(stages: Records) -> dict[str, NDArray[Any]]:
    """Return stages as the arrays of a file, by name; none of no stages."""
    if not stages:
        return {}
    return {
        f"{_FILED}{name}": np.array(values)
        for name, values in zip(StageRecord._fields, zip(*stages, strict=True), strict=True)
    }


def misfit(arrays: Mapping[str, NDArray[Any]], periods: int, trials: int) -> str:
    """Return which array of stages in a file is missing or has a wrong shape; empty if all fit, or there are none.

    Args:
        arrays: of the file, by name.
        periods: number of periods.
        trials: number of trials of all stages together.
    """
    if not any(name.startswith(_FILED) for name in arrays):
        return ""
    of_each = {"trials": (), "side": (), "optimum": (periods,), "rows": (periods, 2), "carried": (periods,)}
    if missing := [name for name in of_each if f"{_FILED}{name}" not in arrays]:
        return f"it lacks {_FILED}{missing[0]}"
    count = arrays[f"{_FILED}trials"].shape[:1]
    for name, shape in of_each.items():
        if arrays[f"{_FILED}{name}"].shape != (*count, *shape):
            return f"its {_FILED}{name} does not fit its stages"
    return "" if arrays[f"{_FILED}trials"].sum() == trials else f"its {_FILED}trials does not fit its steps"


def of_file(arrays: Mapping[str, NDArray[Any]]) -> tuple[StageRecord, ...]:
    """Return the stages that are in the arrays of a file."""
    if f"{_FILED}trials" not in arrays:
        return ()
    columns = [arrays[f"{_FILED}{name}"] for name in StageRecord._fields]
    return tuple(StageRecord(int(trials), float(side), *rest) for trials, side, *rest in zip(*columns, strict=True))
