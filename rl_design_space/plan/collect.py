"""Collect the points of grids: each once, without those that constraints drop, and as readings change them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager

from rl_design_space.config.assemble import Parts
from rl_design_space.errors import ConfigError
from rl_design_space.plan.constraint import Constraint
from rl_design_space.plan.grid import refuse_large
from rl_design_space.plan.plan import Dropped, Plan, PlannedPoint
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.varied import INAPPLICABLE, Varied


class Collector:
    """Collects points.

    Args:
        study: name of the study, or empty.
        planner: plans the points.
        total: number of combinations of all grids, with those of the readings.
        max_points: maximum number of combinations.
        constraints: drop combinations.
        varied: changes each point; None if there are no readings.

    Raises:
        ConfigError: there are too many combinations.
    """

    def __init__(
        self,
        study: str,
        planner: Planner,
        total: int,
        max_points: int,
        constraints: Mapping[str, Constraint] | None = None,
        varied: Varied | None = None,
    ) -> None:
        refuse_large(total, max_points)
        self._study = study
        self._planner = planner
        self._total = total
        self._constraints = constraints or {}
        self._varied = varied
        self._points: dict[str, PlannedPoint] = {}
        self._changed: dict[str, PlannedPoint] = {}
        self._combinations = 0
        self._dropped: Counter[tuple[str, str]] = Counter()

    def add(self, grid: Iterable[Sequence[str]]) -> None:
        """Add the points of a grid, and these points as the readings change them."""
        for overrides in grid:
            parts = self._planner.composer.parts(overrides)
            self._add(parts, overrides, self._points)
            self.vary(parts, overrides)

    def vary(self, parts: Parts, overrides: Sequence[str]) -> None:
        """Add a point as the readings change it, and not the point itself."""
        for changed in self._varied(parts, overrides) if self._varied else ():
            if changed is None:
                self._count()
                self._dropped["variations", INAPPLICABLE] += 1
            else:
                self._add(self._planner.composer.parts(changed), changed, self._changed)

    def plan(self) -> Plan:
        """Return the points: first all of the grids, then the changed ones."""
        dropped = tuple(Dropped(self._study, name, why, count) for (name, why), count in self._dropped.items())
        studies = (self._study,) if self._study else ()
        return Plan(list((self._points | self._changed).values()), studies, self._combinations, dropped)

    def _add(self, parts: Parts, overrides: Sequence[str], points: dict[str, PlannedPoint]) -> None:
        self._count()
        for name, constraint in self._constraints.items():
            with named(f"constraint {name}"):
                drops = constraint.drops(parts)
            if drops:
                self._dropped[name, constraint.why] += 1
                return
        planned = self._planner.of_parts(parts, overrides, (self._study,) if self._study else ())
        points.setdefault(planned.fingerprint, planned)

    def _count(self) -> None:
        self._combinations += 1
        self._planner.progress(self._combinations, self._total)


@contextmanager
def named(place: str, separator: str = ": ") -> Iterator[None]:
    """Put the place in a study before the message of an error."""
    try:
        yield
    except ConfigError as error:
        raise ConfigError(f"{place}{separator}{error}") from error
