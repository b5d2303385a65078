"""Measures of one stage of periods: `total_steps,stage=2`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from typing_extensions import Protocol, runtime_checkable

from rl_design_space._arrays import FloatArray
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measure_kinds import Measure, Periods

#: Name of the parameter.
STAGE = "stage"
_LAST: Literal["last"] = "last"


@runtime_checkable
class _Staged(Protocol):
    """Periods that may have several stages, see `LearningCurves`."""

    @property
    def stages(self) -> Sequence[Any]: ...

    def stage(self, number: int) -> Periods: ...


@dataclass(frozen=True)
class StageMeasure:
    """A measure of one stage; periods without stages have one, themselves.

    Attributes:
        of: the measure.
        stage: number of the stage, from 1, or `last`.
    """

    of: Measure
    stage: int | Literal["last"]

    @property
    def meaning(self) -> str:
        return f"{self.of.meaning}, in {'the last stage' if self.stage == _LAST else f'stage {self.stage}'}"

    @property
    def largest_is_best(self) -> bool:
        return self.of.largest_is_best

    @property
    def is_share(self) -> bool:
        return self.of.is_share

    @property
    def is_first_trial(self) -> bool:
        return self.of.is_first_trial

    def samples(self, periods: Periods, weights: FloatArray) -> FloatArray:
        return self.of.samples(self._alone(periods), weights)

    def each(self, periods: Periods) -> FloatArray | None:
        return self.of.each(self._alone(periods))

    def censored_at(self, periods: Periods) -> float | None:
        return self.of.censored_at(self._alone(periods))

    def with_statistic(self, name: str) -> StageMeasure:
        return replace(self, of=self.of.with_statistic(name))

    def _alone(self, periods: Periods) -> Periods:
        """Return the periods of the stage alone.

        Raises:
            ConfigError: there are fewer stages.
        """
        count = len(periods.stages) if isinstance(periods, _Staged) else 0
        number = max(1, count) if self.stage == _LAST else self.stage
        if number > max(1, count):
            raise ConfigError.at(
                STAGE, number, f"should be from 1 to {max(1, count)}, the stages of this point, or last"
            )
        return periods.stage(number) if isinstance(periods, _Staged) and count else periods


def of_stage(measure: Measure, stage: Any) -> StageMeasure:
    """Return a measure of one stage.

    Raises:
        ConfigError: the stage is neither a number from 1 nor `last`.
    """
    if stage != _LAST and (type(stage) is not int or stage < 1):
        raise ConfigError.at(STAGE, stage, "should be the number of a stage, from 1, or last")
    return StageMeasure(measure, stage)
