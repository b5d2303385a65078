"""Fits of the panels of a published table to points; each is computed once."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.fit import Fit, fit
from rl_design_space.analysis.likelihood import log_density
from rl_design_space.report.points import Point
from rl_design_space.report.published_table import PublishedTable
from rl_design_space.report.reading_points import Cells
from rl_design_space.report.runs import Runs


@dataclass(frozen=True)
class PanelFit:
    """Fit of a panel.

    Attributes:
        recorded: number of cells that are recorded.
        published: number of cells that are published.
        fit: of the means; None unless all cells are recorded.
        densities: log densities of the cells, (cells, numbers of periods); None unless all cells are recorded.
    """

    recorded: int
    published: int
    fit: Fit | None = None
    densities: FloatArray | None = None


class PanelFits:
    """Fits points to the panels of a published table.

    Args:
        runs: the runs of the points.
        published: the table.
    """

    def __init__(self, runs: Runs, published: PublishedTable) -> None:
        self._runs = runs
        self._value = published.value
        self._numbers = {
            panel: {(row, column): number for row, columns in rows.items() for column, number in columns.items()}
            for panel, rows in published.published.items()
        }
        self._found: dict[Hashable, PanelFit] = {}

    def __call__(self, panel: Any, cells: Cells) -> PanelFit:
        """Return the fit of a panel to the points of its cells.

        Raises:
            ConfigError: a run did not keep its periods.
        """
        key = self.key(panel, cells)
        if key not in self._found:
            self._found[key] = self._fit(panel, cells)
        return self._found[key]

    def key(self, panel: Any, cells: Cells) -> Hashable:
        """Return a key that is the same for the same points of a panel."""
        return panel, tuple((cell, *cells.get(cell, ())) for cell in self._numbers[panel])

    def _fit(self, panel: Any, cells: Cells) -> PanelFit:
        numbers = self._numbers[panel]
        recorded = [cell for cell in numbers if cell in cells and all(point.run for point in cells[cell])]
        if len(recorded) < len(numbers):
            return PanelFit(len(recorded), len(numbers))
        values = {cell: self._values(cells[cell]) for cell in recorded}
        densities = [log_density(number, values[cell]) for cell, number in numbers.items()]
        fitted = fit([(values[cell], number) for cell, number in numbers.items()])
        return PanelFit(len(recorded), len(numbers), fitted, np.array(densities))

    def _values(self, points: list[Point]) -> FloatArray:
        """Return what the periods of all seeds contribute to a cell, and forget the runs, of which there are many."""
        found = []
        for point in points:
            self._runs.result(point)  # raises an error if there are no periods
            if (values := self._runs.values(point, self._value)) is not None:
                found.append(values)
            self._runs.forget(point)
        return np.concatenate(found)
