"""A period after a trial, drawn for each success counter: values and greedy actions, and below visits and the path."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap, LogNorm, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.snapshot import Snapshot, edges_of
from rl_design_space.design import MOVES, WAIT
from rl_design_space.errors import ConfigError
from rl_design_space.learning.optimum import needed
from rl_design_space.learning.replay import Replay
from rl_design_space.report.inside.grid import Grid
from rl_design_space.report.style import VERMILION, styled, write_in_full

#: Panels side by side at most.
_ACROSS = 4
#: Sides of a panel in inches, for grids of up to 10 cells, and the largest one; inches for each further cell.
_SMALLEST, _LARGEST, _GROWTH = 3.1, 5.4, 0.115
_EASY = 10
_POINTS_PER_INCH = 72
#: Light enough that black arrows can be read on them.
_LIGHT = (0.14, 0.86)
VALUES = LinearSegmentedColormap.from_list("values", colormaps["RdBu"](np.linspace(*_LIGHT, 256)))
_VISITS = LinearSegmentedColormap.from_list("visits", colormaps["Purples"](np.linspace(0.04, 0.7, 256)))
_UNKNOWN = "0.93"
#: Colours of arrows, by the kind of action: primitive actions first.
_ARROWS = ("0.1", "#7a0177", "#005a32", "#7f2704")
#: Diameter of the circle of an action that waits, as a share of a cell.
_CIRCLE = 0.34


class Picture:
    """The picture of a period, which can show one snapshot after another.

    Args:
        inside: the period.
        first: the snapshot that it shows first.
        scale: snapshots whose values and visits the colour scales cover; that of `first` alone if empty.
        title: first line above the panels.
    """

    @styled()
    def __init__(self, inside: Replay, first: Snapshot, title: str, scale: tuple[Snapshot, ...] = ()) -> None:
        self._inside, self._grid, self._title = inside, Grid(inside.point), title
        self._kinds = list(dict.fromkeys(inside.point.msa.labels))
        self._kind_of_actions = np.array([self._kinds.index(label) for label in inside.point.msa.labels])
        goals = len(inside.goals)
        self._across = min(goals, _ACROSS)
        blocks = -(-goals // self._across)
        side = min(_SMALLEST + _GROWTH * max(0, max(self._grid.width, self._grid.height) - _EASY), _LARGEST)
        size = np.array([self._grid.width, self._grid.height]) / max(self._grid.width, self._grid.height) * side
        self._cell = side / max(self._grid.width, self._grid.height) * _POINTS_PER_INCH
        self.figure, axes = plt.subplots(
            2 * blocks, self._across, squeeze=False, layout="compressed",
            figsize=(self._across * (size[0] + 0.1) + 1.5, 2 * blocks * (size[1] + 0.15) + 1.0),
        )  # fmt: skip
        self._above = [axes[2 * (goal // self._across), goal % self._across] for goal in range(goals)]
        self._below = [axes[2 * (goal // self._across) + 1, goal % self._across] for goal in range(goals)]
        for axis in set(axes.ravel()) - {*self._above, *self._below}:
            axis.set_axis_off()
        shown = scale or (first,)
        self._value_images = [self._image(axis, VALUES, value_norm(shown)) for axis in self._above]
        self._visit_images = [self._image(axis, _VISITS, self._visit_norm(shown)) for axis in self._below]
        for goal, (above, below) in enumerate(zip(self._above, self._below, strict=True)):
            for axis in (above, below):
                self._grid.draw(axis)
                self._grid.draw_places(axis, inside.layout, goal, self._cell)
            self._grid.draw_observations(above, inside.row[goal])
            above.set_title(f"to goal {goal + 1}" if goals > 1 else "to the goal", fontsize=10)
        for block in range(blocks):
            axes[2 * block, 0].set_ylabel("value and greedy actions")
            axes[2 * block + 1, 0].set_ylabel("visits and path")
        self._bar(self._above, self._value_images[0], "largest Q-value")
        self._bar(self._below, self._visit_images[0], "visits up to this trial")
        self._legend()
        self._moving: list[Any] = []
        self.show(first)

    @styled()
    def show(self, snapshot: Snapshot) -> Figure:
        """Show a snapshot; return the figure."""
        for artist in self._moving:
            artist.remove()
        self._moving = []
        for goal in range(len(self._inside.goals)):
            is_open = self._grid.is_open
            values = np.ma.masked_where(~(snapshot.learned[goal] & is_open), snapshot.values[goal])
            self._value_images[goal].set_data(self._grid.image(values))
            visits = snapshot.visits[goal]
            self._visit_images[goal].set_data(self._grid.image(np.ma.masked_equal(visits, 0)))
            self._arrows(self._above[goal], goal, snapshot)
            self._path(self._below[goal], *edges_of(snapshot.path, goal))
        self.figure.suptitle(f"{self._title}\n{told(self._inside, snapshot)}", fontsize=11)
        return self.figure

    def _image(self, axis: Axes, colours: LinearSegmentedColormap, norm: Any) -> Any:
        axis.set_facecolor(_UNKNOWN if colours is VALUES else "white")
        nothing = np.ma.masked_equal(np.zeros((self._grid.height, self._grid.width)), 0)
        return axis.imshow(nothing, cmap=colours, norm=norm, interpolation="nearest", zorder=1)

    def _bar(self, axes: list[Axes], image: Any, label: str) -> None:
        """Draw a colour scale, with its numbers in full."""
        bar = self.figure.colorbar(image, ax=axes, shrink=0.85, pad=0.012, aspect=28, label=label)
        bar.outline.set_visible(False)
        if isinstance(image.norm, TwoSlopeNorm):
            low, high = float(image.norm.vmin or 0), float(image.norm.vmax or 0)
            ticks = [low, low / 2, 0, high / 2, high]
            bar.set_ticks(ticks, labels=[f"{tick:.2g}" for tick in ticks])
        else:
            write_in_full(bar.ax.yaxis)

    def _visit_norm(self, shown: tuple[Snapshot, ...]) -> LogNorm:
        return LogNorm(1, max(2, max(int(each.visits.max()) for each in shown)))

    def _arrows(self, axis: Axes, goal: int, snapshot: Snapshot) -> None:
        """Draw the greedy actions of the states whose values are known; several if they are equal, none if all are."""
        greedy = snapshot.greedy[goal]
        drawn = snapshot.learned[goal] & self._grid.is_open & ~greedy.all(axis=1)
        drawn[self._inside.goals[goal]] = False  # no action is chosen there: the next counter begins
        goes = self._inside.made[:, goal].T != WAIT
        self._circles(axis, greedy & ~goes & drawn[:, np.newaxis])
        cells, actions = np.nonzero(greedy & goes & drawn[:, np.newaxis])
        if not cells.size:
            return
        alone = greedy.sum(axis=1)[cells] == 1
        ways = np.array(MOVES, dtype=np.float64)[self._inside.made[actions, goal, cells]]
        kinds = self._kind_of_actions[actions]
        places = self._grid.at(cells.astype(np.int32))
        # A single action in the middle of its cell; equal ones from the middle outwards.
        tails = places - np.where(alone[:, np.newaxis], 0.36 * ways, 0)
        length = np.where(alone, 0.72, 0.42)[:, np.newaxis]
        for kind in np.unique(kinds):
            of_kind = kinds == kind
            arrows = axis.quiver(
                *tails[of_kind].T, *(ways * length)[of_kind].T, angles="xy", scale_units="xy", scale=1, units="dots",
                width=float(np.clip(0.09 * self._cell, 0.7, 2.2)) * self.figure.dpi / _POINTS_PER_INCH,
                headwidth=4, headlength=4.2, headaxislength=3.8, minlength=0,
                color=_ARROWS[int(kind) % len(_ARROWS)], zorder=2,
            )  # fmt: skip
            self._moving.append(arrows)

    def _circles(self, axis: Axes, waits: NDArray[np.bool_]) -> None:
        """Draw greedy actions that wait, (cells, actions), which have no direction."""
        cells, actions = np.nonzero(waits)
        if cells.size:
            colours = [_ARROWS[kind % len(_ARROWS)] for kind in self._kind_of_actions[actions]]
            places = self._grid.at(cells.astype(np.int32))
            size = (_CIRCLE * self._cell) ** 2
            x, y = places.T
            circles = axis.scatter(x, y, s=size, facecolors="none", edgecolors=colours, linewidths=1.4, zorder=2)
            self._moving.append(circles)

    def _path(self, axis: Axes, edges: NDArray[np.int32], counts: NDArray[np.int64]) -> None:
        """Draw a path; steps made more often are drawn wider."""
        if not len(edges):
            return
        lines, owners = self._grid.segments(edges)
        often = np.log10(counts[owners])
        widths: FloatArray = np.minimum(1.3 + 0.9 * often, 0.3 * self._cell)
        # Where a trial covers the grid, what it did once fades behind what it did again and again.
        strength = 1 if often.max() < 1 else 0.25 + 0.75 * often / often.max()
        path = LineCollection(lines, colors=VERMILION, linewidths=widths, capstyle="round", alpha=strength, zorder=4)
        self._moving.append(axis.add_collection(path))

    def _legend(self) -> None:
        handles: list[Any] = [
            Line2D([], [], color=VERMILION, linewidth=2, label="path of this trial, wider where it went more often"),
            Line2D([], [], marker="s", color=_UNKNOWN, markeredgecolor="0.6", linestyle="none", label="never learned"),
        ]
        if len(self._kinds) > 1:
            handles += [
                Line2D([], [], color=_ARROWS[kind % len(_ARROWS)], marker=">", markersize=4, label=label)
                for kind, label in enumerate(self._kinds)
            ]
        if (self._inside.made == WAIT).any():
            looks: dict[str, Any] = {"marker": "o", "markerfacecolor": "none", "markeredgecolor": _ARROWS[0]}
            handles.append(Line2D([], [], linestyle="none", label="action that waits in this cell", **looks))
        if any(len(np.unique(row)) < len(row) for row in self._inside.row):
            handles.append(Line2D([], [], color="0.25", linewidth=0.8, label="border between observations"))
        self.figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False, fontsize=8)


def value_norm(shown: tuple[Snapshot, ...]) -> TwoSlopeNorm:
    """Return the scale of values: zero in its middle, and both sides up to their end, however small one of them is.

    Raises:
        ConfigError: a value is not finite, so that it has no place on a scale.
    """
    for each in shown:
        if not np.isfinite(each.values[each.learned]).all():
            raise ConfigError(
                f"reward: after trial {each.trial}, Q-values are infinite or not a number, so they have no colours; "
                "smaller rewards, or a smaller learner.gamma, keep them finite"
            )
    learned = np.concatenate([each.values[each.learned] for each in shown])
    low, high = (float(learned.min()), float(learned.max())) if learned.size else (0.0, 0.0)
    # One strength of colour on both sides would hide small negative values, which traps have.
    return TwoSlopeNorm(0, min(low, -1e-3), max(high, 1e-3))


def told(inside: Replay, snapshot: Snapshot) -> str:
    """Return a snapshot in words."""
    if snapshot.success:
        end = f"{snapshot.steps:,} steps, {needed(inside.optimum)}"
    else:
        reached = int(snapshot.path.counters[-1])
        end = f"failed after {snapshot.steps:,} steps, {reached} of {len(inside.goals)} goals reached"
    explored = float(snapshot.path.explored.mean())
    return f"after trial {snapshot.trial}: {end}; {explored:.0%} of the steps exploratory"
