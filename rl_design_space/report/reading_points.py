"""Points of the cells of a published table under readings of the text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rl_design_space.errors import ConfigError
from rl_design_space.plan.differences import differing
from rl_design_space.report.points import Point, by_design
from rl_design_space.tracking.selection import Where, comparable

#: The points of the cells of a panel, one for each seed, by row and column.
Cells = Mapping[tuple[Any, Any], list[Point]]


class ReadingPoints:
    """Finds points by reading and panel.

    Args:
        points: the points.
        axes: parameters that make up panel, row and column of the table.
        decided: values of parameters that a point has unless a reading says otherwise.
        readings: what each reading says, by its name.

    Raises:
        ConfigError: a reading changes a parameter that `decided` does not name.
    """

    def __init__(
        self, points: Sequence[Point], axes: Sequence[str], decided: Where, readings: Mapping[str, Where]
    ) -> None:
        self._decided = decided
        for reading, says in readings.items():
            if rest := says.keys() - decided.keys():
                raise ConfigError(f"decided: should have {', '.join(sorted(rest))}, which reading {reading} changes")
        #: By panel and by those of the named parameters that a point has: designs by the values of these.
        self._designs: dict[Any, dict[tuple[str, ...], dict[tuple[Any, ...], list[list[Point]]]]] = {}
        self._axes = axes
        for seeds in by_design(points):
            parameters = seeds[0].parameters
            names = tuple(name for name in decided if name in parameters)
            panel, *_ = seeds[0].key(axes)
            values = tuple(parameters[name] for name in names)
            self._designs.setdefault(panel, {}).setdefault(names, {}).setdefault(values, []).append(seeds)

    def under(self, panel: Any, says: Where) -> Cells:
        """Return the points of a panel under a reading.

        Raises:
            ConfigError: several designs are one cell.
        """
        wanted = {**self._decided, **says}
        cells: dict[tuple[Any, Any], list[Point]] = {}
        for names, designs in self._designs.get(panel, {}).items():
            for seeds in designs.get(tuple(comparable(wanted[name]) for name in names), ()):
                _, row, column = seeds[0].key(self._axes)
                if (first := cells.setdefault((row, column), seeds)) is not seeds:
                    differ = ", ".join(differing([first[0].parameters, seeds[0].parameters]))
                    raise ConfigError(f"{differ}: several values for one cell under one reading; choose one of them")
        return cells
