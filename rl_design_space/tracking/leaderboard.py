"""Measures that the points of a sweep are ranked by, where they are not among the recorded scalars."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import SCALARS, measure, values
from rl_design_space.tracking.store_errors import StoreUnavailableError
from rl_design_space.tracking.tracker import StoredRun

if TYPE_CHECKING:
    from rl_design_space.learning.result import LearningCurves
    from rl_design_space.tracking.address import StoreAddress


class Leaderboard:
    """Computes measures of points: of new ones when they are recorded, of others from the files of their runs.

    What cannot be computed is left out: a result is worth more than its place in a table.

    Args:
        names: of scalars and measures.
        address: of the store with the runs.

    Raises:
        ConfigError: there is no such measure, or its module cannot be imported.
    """

    def __init__(self, names: Sequence[str], address: StoreAddress) -> None:
        self.names = tuple(names)
        self._computed = [name for name in names if name not in SCALARS]
        for name in self._computed:
            measure(name)
        self._address = address
        #: Measures by fingerprint.
        self._known: dict[str, dict[str, float]] = {}

    def add(self, fingerprint: str, result: LearningCurves) -> None:
        """Compute the measures of a point that is recorded."""
        if self._computed:
            self._known[fingerprint] = self._values(result)

    def measured(self, stored: Mapping[str, StoredRun], *, may_read: bool) -> dict[str, StoredRun]:
        """Return runs with the measures among their scalars, both by fingerprint.

        Args:
            stored: runs by fingerprint.
            may_read: whether measures of points that were not recorded now are computed from the files of their runs.
        """
        if not self._computed:
            return dict(stored)
        read = self._read({key: run for key, run in stored.items() if key not in self._known}) if may_read else {}
        known = {**read, **self._known}
        return {key: replace(run, scalars={**run.scalars, **known.get(key, {})}) for key, run in stored.items()}

    def _read(self, stored: Mapping[str, StoredRun]) -> dict[str, dict[str, float]]:
        from rl_design_space.learning.result import LearningCurves
        from rl_design_space.tracking.read import RunReader

        found: dict[str, dict[str, float]] = {}
        try:
            reader = RunReader(self._address)
            for fingerprint, run in stored.items():
                if run.artifacts:
                    scaled, total = (run.scalars.get(name, 0) for name in ("total_steps_scaled", "total_steps"))
                    result = LearningCurves.found(reader.periods(run), 10 * total / scaled if scaled else None)
                    found[fingerprint] = self._values(result) if result else {}
        except (ConfigError, StoreUnavailableError):  # a file or the store cannot be read
            return found
        return found

    def _values(self, result: LearningCurves) -> dict[str, float]:
        found: dict[str, float] = {}
        for name in self._computed:
            try:
                found |= values([name], result)
            except ConfigError:  # such as a function of the user's own that returns NaN
                continue
        return found
