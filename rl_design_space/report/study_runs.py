"""The tracked runs of a study, for reports: points by their parameters, and what their periods were."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rl_design_space.errors import ConfigError
from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.plan import Plan, PlannedPoint

if TYPE_CHECKING:
    from rl_design_space.tracking.read import Reader
    from rl_design_space.tracking.tracker import StoredRun

#: Values of parameters by name; a list of values means any of them.
Where = Mapping[str, Any]


class Runs:
    """The points of a plan with their runs; each run is read once.

    Args:
        plan: the points that a report is about.
        reader: of the store.
    """

    def __init__(self, plan: Plan, reader: Reader) -> None:
        self._reader = reader
        self._parameters = {planned.fingerprint: planned.parameters for planned in plan}
        self._read: dict[str, LearningCurves] = {}
        self.plan = plan
        self.stored: Mapping[str, StoredRun] = reader.finished(list(self._parameters))

    @property
    def missing(self) -> list[PlannedPoint]:
        """Points without a complete run."""
        return [planned for planned in self.plan if planned.fingerprint not in self.stored]

    def where(self, where: Where) -> list[PlannedPoint]:
        """The points that have these values, recorded or not, in the order of the plan.

        Raises:
            ConfigError: no point has a parameter of that name.
        """
        for name in where:
            if not any(name in parameters for parameters in self._parameters.values()):
                known = {known for parameters in self._parameters.values() for known in parameters}
                raise ConfigError.unknown("parameter of these points", name, known)
        return [planned for planned in self.plan if _matches(self._parameters[planned.fingerprint], where)]

    def one(self, where: Where) -> PlannedPoint:
        """The only point that has these values.

        Raises:
            ConfigError: there is none, or there are several.
        """
        found = self.where(where)
        if len(found) != 1:
            asked = " ".join(f"{name}={value}" for name, value in where.items())
            raise ConfigError(f"{asked}: should be one point of {self.plan.name}, not {len(found)}")
        return found[0]

    def periods(self, planned: PlannedPoint) -> LearningCurves | None:
        """What was recorded of a point; None if it has no complete run."""
        key = planned.fingerprint
        if key not in self.stored:
            return None
        if key not in self._read:
            arrays = self._reader.periods(self.stored[key])
            self._read[key] = LearningCurves.of_arrays(arrays, planned.point)
        return self._read[key]


def _matches(parameters: Mapping[str, Any], where: Where) -> bool:
    for name, wanted in where.items():
        values = [wanted, *wanted] if isinstance(wanted, (list, tuple)) else [wanted]  # the list itself may be meant
        if name not in parameters or _plain(parameters[name]) not in [_plain(value) for value in values]:
            return False
    return True


def _plain(value: Any) -> Any:
    """A value that can be compared and hashed: a list as it is written, e.g. `[3, 5]`."""
    return str(value) if isinstance(value, (list, tuple)) else value
