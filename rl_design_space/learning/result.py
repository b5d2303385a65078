"""The result of learning a design point: steps of every trial of every period, and numbers computed from them."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Literal

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray, Optimum
from rl_design_space.learning.archive import read_arrays, write_arrays
from rl_design_space.learning.measures import MEASURES, SCALARS, scaled_to_equal_steps
from rl_design_space.learning.stage_record import (
    STAGE_CURVE,
    StageRecord,
    bounds,
    by_trial,
    filed,
    of_file,
    stage_curve,
    stage_scalars,
)

if TYPE_CHECKING:
    import pandas as pd

    from rl_design_space.design import DesignPoint
    from rl_design_space.learning.replay import Replay

#: What a file holds of a result: everything, or the learning curves only.
Kept = Literal["periods", "curves"]
#: Prefix of the names of learning curves in a file.
_CURVE = "curve:"


@dataclass(frozen=True, eq=False)
class LearningCurves:
    """The result of learning one design point, with each period separate.

    Attributes:
        steps: (periods, trials) int32, steps until the final goal; the step cap where it was missed.
        success: (periods, trials) bool, whether the final goal was reached.
        optimum: (periods,) int32, fewest steps possible; float64 in a stochastic world, the fewest to be expected.
        rows: (periods, 2) int32, rows of the Q-matrix, one for each observation that can occur in the period, and rows
            that learning has changed: an action has another value than initially.
        epsilon: (trials,) float64, the exploration schedule.
        seconds: wall time of learning; NaN if it is not known.
        known_point: see `point`; None where the components of the point cannot be built.
        known_side: see `side`; None where the point tells it.
        stages: the stages of periods that have several, with their trials one after the other; `optimum` and `rows` are
            then those of the last one.
        ended_at: when learning ended, in seconds since 1970; NaN if it is not known, and not saved.
        inside: Q-matrices, visits and paths of periods by number, if `simulate` was asked to keep them; not saved.
    """

    steps: NDArray[np.int32]
    success: NDArray[np.bool_]
    optimum: Optimum
    rows: NDArray[np.int32]
    epsilon: FloatArray
    seconds: float = math.nan
    known_point: DesignPoint | None = None
    known_side: float | None = None
    stages: tuple[StageRecord, ...] = ()
    inside: Mapping[int, Replay] = field(default_factory=dict)
    ended_at: float = math.nan

    @property
    def point(self) -> DesignPoint:
        """The design point that was learned.

        Raises:
            LookupError: the result was loaded without it.
        """
        if self.known_point is None:
            raise LookupError("this result was loaded without its design point")
        return self.known_point

    def __repr__(self) -> str:
        from rl_design_space.learning.result_frame import text_of

        final = MEASURES["final_steps_over_optimum"].each(self)
        assert final is not None
        return text_of(self, self._standard_error if len(self.steps) > 1 else None, float(final.mean()))

    def first(self, periods: int) -> LearningCurves:
        """Return the result of the first periods: what the same point with fewer of them gives, bit for bit.

        Raises:
            ValueError: there are not so many.
        """
        if not 1 <= periods <= len(self.steps):
            raise ValueError(f"periods={periods}: should be from 1 to {len(self.steps)}")
        point = self.known_point and replace(self.known_point, task=replace(self.known_point.task, periods=periods))
        seconds = self.seconds * periods / len(self.steps)
        return replace(self.of_periods(slice(periods)), seconds=seconds, known_point=point)

    @cached_property
    def total_steps(self) -> FloatArray:
        """(periods,) steps of a whole period, failed trials included at the step cap."""
        total: FloatArray = self.steps.sum(axis=1, dtype=np.float64)
        return total

    @cached_property
    def optima(self) -> Optimum:
        """(periods, trials) fewest steps possible, or (periods, 1) if they are the same in all trials."""
        if not self.stages:
            return self.optimum[:, np.newaxis]
        return by_trial(self.stages, [stage.optimum for stage in self.stages])

    @cached_property
    def over_optimum(self) -> FloatArray:
        """(periods, trials) steps / optimum."""
        ratio: FloatArray = self.steps / self.optima
        return ratio

    @cached_property
    def scaled_steps(self) -> FloatArray:
        """(periods,) total steps · 10/d, steps of equal length on square grids of any size d; NaN on others."""
        if not self.stages:
            return np.asarray(scaled_to_equal_steps(self.total_steps, self.side))
        sides = by_trial(self.stages, [stage.side for stage in self.stages])
        scaled: FloatArray = scaled_to_equal_steps(self.steps, sides).sum(axis=1)
        return scaled

    @property
    def side(self) -> float:
        """Cells along each side of the grid; NaN if it is not square, or the point is not known."""
        if self.known_side is not None:
            return self.known_side
        return _side(self.known_point.world.shape) if self.known_point else math.nan

    @cached_property
    def computed(self) -> dict[Hashable, Any]:
        """What was computed from these periods before, by what it is; it is kept as long as the result."""
        return {}

    @cached_property
    def curves(self) -> dict[str, FloatArray]:
        """Every learning curve by its name, each (trials,)."""
        # NumPy sorts integers with vector instructions, but selects quantiles without: sorting first halves the time.
        q10, median, q90 = np.quantile(np.sort(self.steps, axis=0), (0.1, 0.5, 0.9), axis=0)
        return {
            "steps/mean": self.steps.mean(axis=0),
            "steps/median": median,
            "steps/q10": q10,
            "steps/q90": q90,
            "steps/over_optimum": self.over_optimum.mean(axis=0),
            "success_rate": self.success.mean(axis=0),
            "epsilon": self.epsilon,
            **({STAGE_CURVE: stage_curve(self.stages)} if self.stages else {}),
        }

    def stage(self, number: int) -> LearningCurves:
        """Return the result of one stage alone, the first of which has number 1.

        Raises:
            LookupError: there is no such stage.
        """
        if not 1 <= number <= len(self.stages):
            raise LookupError(f"stage {number}: this result has {len(self.stages)} stages")
        stage, trials = self.stages[number - 1], bounds(self.stages)[number - 1]
        share = stage.trials / self.steps.shape[1]
        return LearningCurves(
            self.steps[:, trials], self.success[:, trials], stage.optimum, stage.rows, self.epsilon[trials],
            self.seconds * share, known_side=stage.side,
        )  # fmt: skip

    def of_periods(self, some: Any) -> LearningCurves:
        """Return the result of some of the periods, which an index of arrays selects."""
        stages = tuple(stage.of_periods(some) for stage in self.stages)
        arrays = {name: getattr(self, name)[some] for name in ("steps", "success", "optimum", "rows")}
        return replace(self, **arrays, stages=stages)

    def to_frame(self, *, periods: bool = False) -> pd.DataFrame:
        """Return a tidy frame.

        Args:
            periods: one row for each period and trial, instead of one for each trial.

        Returns:
            trial and every learning curve by its name; or period, trial, steps, success, the period's optimum, and
            epsilon, the periods one after the other.
        """
        from rl_design_space.learning.result_frame import frame_of

        return frame_of(self, periods=periods)

    def scalars(self, shape: tuple[int, int] | None = None) -> dict[str, float]:
        """Return the numbers that are recorded of a point; those that are not defined are left out.

        Args:
            shape: of the world, cells along x and y; that of the point if None.

        Returns:
            total_steps: mean over periods of the steps of all trials.
            total_steps_sem: its standard error; not of one period.
            total_steps_scaled: total_steps · 10/d, steps of equal length on square grids of any size d (Table 4).
            failed_trials, failed_periods: share of trials, and of periods with a trial, that missed the final goal.
            final_steps_over_optimum: mean of steps / optimum over the last `FINAL_TRIALS` trials.
            env_steps_per_second: steps learned a second.
            stage2/total_steps, …: the same of each stage; its mean optimum, and the share of rows with carried values.
        """
        values = {"env_steps_per_second": float(self.total_steps.sum() / self.seconds)}
        if len(self.steps) > 1:
            values["total_steps_sem"] = self._standard_error
        side = self.side if shape is None else _side(shape)
        for name in MEASURES.keys() & set(SCALARS) - {"total_steps_scaled"}:  # which `shape` may override
            each = MEASURES[name].each(self)
            assert each is not None
            values[name] = float(each.mean())
        values["total_steps_scaled"] = (
            float(self.scaled_steps.mean()) if self.stages else scaled_to_equal_steps(values["total_steps"], side)
        )
        known = {name: values[name] for name in SCALARS if name in values and not math.isnan(values[name])}
        return known | stage_scalars(self.stages, lambda number: self.stage(number).scalars())

    def save(self, file: Path | BinaryIO, *, keep: Kept = "periods", compress: bool = True) -> None:
        """Write the result as an .npz file, the same bytes for the same result; without its point and its seconds.

        Args:
            file: path or open file.
            keep: `periods` for everything; `curves` for the learning curves only, which cannot be loaded again.
            compress: whether to spend processor time on a smaller file: learning curves are written, too, and all
                arrays are deflated.
        """
        periods: dict[str, NDArray[Any]] = {
            "steps": _narrow(self.steps),
            "success": self.success,
            "optimum": self.optimum,
            "rows": self.rows,
        }
        curves = self.curves if compress else {"epsilon": self.epsilon}
        named = {f"{_CURVE}{name}": curve for name, curve in curves.items()}
        kept = {**periods, **filed(self.stages)} if keep == "periods" else {}
        write_arrays(file, {**kept, **named}, compress=compress)

    @classmethod
    def load(cls, file: Path | BinaryIO, point: DesignPoint | None = None, seconds: float = math.nan) -> LearningCurves:
        """Read a result that `save` has written.

        Args:
            file: path or open file.
            point: that was learned, if it is known.
            seconds: wall time of learning, if it is known.

        Raises:
            LookupError: the file holds the learning curves only.
        """
        return cls.of_arrays(read_saved(file), point, seconds)

    @classmethod
    def of_arrays(
        cls,
        arrays: Mapping[str, NDArray[Any]],
        point: DesignPoint | None = None,
        seconds: float = math.nan,
        side: float | None = None,
    ) -> LearningCurves:
        """Return the result of these arrays, see `read_saved`.

        Args:
            arrays: by name.
            point: that was learned, if it is known.
            seconds: wall time of learning, if it is known.
            side: cells along each side of the grid, if the point is not known.

        Raises:
            LookupError: the periods are not among them.
        """
        if "steps" not in arrays:
            raise LookupError("this file holds the learning curves alone, not the periods")
        steps = arrays["steps"].astype(np.int32)
        success, optimum, rows, epsilon = (arrays[name] for name in ("success", "optimum", "rows", "epsilon"))
        return cls(steps, success, optimum, rows, epsilon, seconds, point, side, of_file(arrays))

    @classmethod
    def found(cls, arrays: Mapping[str, NDArray[Any]], size: Any) -> LearningCurves | None:
        """Return the result of a run that was found in a store; None if it kept its learning curves alone.

        Args:
            arrays: see `read_saved`.
            size: of the world, as frames of runs have it: a number, perhaps as text, if the grid is square.
        """
        try:
            side = float(size)
        except (TypeError, ValueError):
            side = math.nan
        return cls.of_arrays(arrays, side=side) if "steps" in arrays else None

    @property
    def _standard_error(self) -> float:
        return float(self.total_steps.std(ddof=1) / math.sqrt(len(self.steps)))


def read_saved(file: Path | BinaryIO) -> dict[str, NDArray[Any]]:
    """Return what a file of a result holds: steps, success, optimum and rows, if kept, and learning curves by name."""
    return {name.removeprefix(_CURVE): array for name, array in read_arrays(file).items()}


def _narrow(steps: NDArray[np.int32]) -> NDArray[np.unsignedinteger[Any]]:
    """Return steps as uint16 where they fit, which halves a file, else as uint32."""
    return steps.astype(np.uint16 if steps.max() <= np.iinfo(np.uint16).max else np.uint32)


def _side(shape: tuple[int, int]) -> float:
    return shape[0] if shape[0] == shape[1] else math.nan
