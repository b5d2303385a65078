"""The grid of a period as every picture of it has it: walls, start, goals, and cells that share an observation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.design import DesignPoint, Torus, cell_count, open_cells, undisturbed
from rl_design_space.report.style import BLUE, ORANGE

#: Where the border between a cell and its neighbour on the right, on the left, above and below begins and ends.
_BORDERS = np.array(
    [[[0.5, -0.5], [0.5, 0.5]], [[-0.5, -0.5], [-0.5, 0.5]], [[-0.5, -0.5], [0.5, -0.5]], [[-0.5, 0.5], [0.5, 0.5]]]
)
_WALL = "0.15"
#: Colour of cells that cannot be entered.
_OBSTACLE = "0.35"


class Grid:
    """Coordinates, walls and obstacles of the world of a point.

    Args:
        point: the design point.
    """

    def __init__(self, point: DesignPoint) -> None:
        self.width, self.height = point.world.shape
        world = undisturbed(point.world)
        self.next_cell = world.next_cell()
        self.is_open = np.zeros(cell_count(point.world), dtype=np.bool_)
        self.is_open[open_cells(point.world)] = True
        self.is_torus = isinstance(world, Torus)

    def at(self, cells: NDArray[np.int32]) -> FloatArray:
        """Return the coordinates of cells, (…, 2); y grows downwards."""
        y, x = np.divmod(cells, self.width)
        return np.stack([x, y], axis=-1).astype(np.float64)

    def image(self, numbers: NDArray[np.generic]) -> NDArray[np.generic]:
        """Return numbers of the cells as an image."""
        return numbers.reshape(self.height, self.width)

    def draw(self, axis: Axes) -> None:
        """Draw border, walls and obstacles."""
        axis.set_xlim(-0.5, self.width - 0.5)
        axis.set_ylim(self.height - 0.5, -0.5)
        axis.set_aspect("equal")
        axis.set_xticks([])
        axis.set_yticks([])
        for side in axis.spines.values():
            side.set_color("0.6")
            if self.is_torus:  # open: who leaves on one side comes back on the other
                side.set_linestyle((0, (4, 3)))
        blocked = self.at(np.flatnonzero(~self.is_open).astype(np.int32))
        for x, y in blocked:
            axis.fill_between([x - 0.5, x + 0.5], y - 0.5, y + 0.5, color=_OBSTACLE, linewidth=0, zorder=1.5)
        axis.add_collection(LineCollection(list(self._walls()), colors=_WALL, linewidths=1.8, zorder=3))

    def draw_observations(self, axis: Axes, row: NDArray[np.int32]) -> None:
        """Draw a line between neighbouring cells with different observations, if any cells share one.

        Args:
            axis: of the picture.
            row: (cells,) row of the Q-matrix of each cell, at one success counter.
        """
        if len(np.unique(row)) == len(row):
            return
        grid = self.image(row)
        y, x = np.nonzero(grid[:, :-1] != grid[:, 1:])
        beside = np.stack([x, y], axis=-1)[:, np.newaxis] + _BORDERS[0]
        y, x = np.nonzero(grid[:-1] != grid[1:])
        below = np.stack([x, y], axis=-1)[:, np.newaxis] + _BORDERS[3]
        lines = np.concatenate([beside, below])
        axis.add_collection(LineCollection(list(lines), colors="0.25", linewidths=0.7, alpha=0.75, zorder=1.6))

    def draw_places(self, axis: Axes, layout: NDArray[np.int32], counter: int, size: float) -> None:
        """Draw where the agent begins, the goal that is due, and the other goals.

        Args:
            axis: of the picture.
            layout: start and goals.
            counter: number of goals reached.
            size: of a cell in points.
        """
        mark, font = float(np.clip(0.85 * size, 9, 26)), float(np.clip(0.5 * size, 6.5, 13))
        goals = self.at(layout[1:])
        for number, (x, y) in enumerate(goals, 1):
            due = number == counter + 1
            fill, edge = (ORANGE, "black") if due else ("white", "0.35")
            axis.plot(
                x, y, marker="s", markersize=mark, markerfacecolor=fill, markeredgecolor=edge, markeredgewidth=0.9,
                zorder=6 if due else 5,
            )  # fmt: skip
            axis.annotate(
                str(number), (x, y), ha="center", va="center_baseline", fontsize=font,
                fontweight="bold" if due else "normal", color="black" if due else "0.3", zorder=7,
            )  # fmt: skip
        if counter == 0:
            ((x, y),) = self.at(layout[:1])
            axis.plot(x, y, marker="o", markersize=mark, color=BLUE, markeredgecolor="white", zorder=6)
            axis.annotate(
                "S", (x, y), ha="center", va="center_baseline", fontsize=font, fontweight="bold", color="white",
                zorder=7,
            )  # fmt: skip
        else:
            x, y = goals[counter - 1]
            axis.plot(
                x, y, marker="o", markersize=1.25 * mark, markerfacecolor="none", markeredgecolor=BLUE,
                markeredgewidth=1.6, zorder=6,
            )  # fmt: skip

    def segments(self, edges: NDArray[np.int32]) -> tuple[list[FloatArray], NDArray[np.int64]]:
        """Return the lines of steps between cells; one over a border of the grid is drawn at both sides of it.

        Args:
            edges: (edges, 2) cells before and after.

        Returns:
            Lines, each (2, 2), and the number of the edge that each belongs to.
        """
        lines: list[FloatArray] = []
        owners: list[int] = []
        for number, (before, after) in enumerate(self.at(edges)):
            if (before == after).all():  # against a wall
                continue
            way = after - before
            parts = [np.stack([before, after])]
            if (2 * np.abs(way) > (self.width, self.height)).any() and np.abs(way).max() > 1:
                outwards = -np.sign(way)
                parts = [np.stack([before, before + 0.5 * outwards]), np.stack([after - 0.5 * outwards, after])]
            lines += parts
            owners += [number] * len(parts)
        return lines, np.array(owners, dtype=np.int64)

    def _walls(self) -> Iterator[FloatArray]:
        """Yield the borders that no step crosses."""
        for move, border in enumerate(_BORDERS):
            cells = np.flatnonzero((self.next_cell[move] == np.arange(len(self.is_open))) & self.is_open)
            yield from self.at(cells.astype(np.int32))[:, np.newaxis] + border
