"""A scenario drawn, with the representations of the state that it shows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.design import MOVES, Direction, Distance, Torus
from rl_design_space.errors import ConfigError
from rl_design_space.report.base import MAIN, Frames, Report, Text
from rl_design_space.report.markdown import table
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import BLUE, ORANGE, styled

Cell = Annotated[tuple[int, int], Field(strict=False)]
#: Names of the directions, by the code of a world with one goal.
_DIRECTIONS = ("here", "right", "left", "above", "below")


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Scenario(Report):
    """An agent and its goals on a torus.

    Attributes:
        size: side of the grid.
        agent: its column and row, from 1, counted from the upper left.
        goals: columns and rows of the goals in their order.
    """

    title: Text
    shows: str = (
        "A grid with an agent and numbered goals, the four moves, and the same state as it is seen by the ad hoc, "
        "distance and direction representations"
    )
    size: Annotated[int, Field(ge=2)]
    agent: Cell
    goals: Annotated[tuple[Cell, ...], Field(strict=False, min_length=1)]

    def frames(self, runs: Runs) -> Frames:
        return {MAIN: self.seen()}

    def seen(self) -> pd.DataFrame:
        """Return what each representation sees in this state: representation, sees.

        Raises:
            ConfigError: the agent or a goal lies outside the grid.
        """
        for column, row in (self.agent, *self.goals):
            if not (1 <= column <= self.size and 1 <= row <= self.size):
                raise ConfigError(f"study.report: ({column}, {row}) lies outside of a grid of {self.size}×{self.size}")
        world = Torus(size=self.size)
        goals = np.array([self._cell(goal) for goal in self.goals], dtype=np.int32)
        agent = self._cell(self.agent)
        alone = goals[:, np.newaxis]  # one layout for each goal: its code then is that goal's share alone
        distances = Distance().observation(world, alone)[:, 0, agent].tolist()
        directions = Direction().observation(world, alone)[:, 0, agent].tolist()
        seen = {
            "ad hoc": f"({', '.join(map(str, self.agent))})",
            "distance": f"({', '.join(map(str, distances))})",
            "direction": f"({', '.join(_DIRECTIONS[code] for code in directions)})",
        }
        return pd.DataFrame({"representation": list(seen), "sees": list(seen.values())})

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self.title, self.size, self.agent, self.goals)

    def text(self, frames: Frames) -> list[str]:
        """Return what each representation sees, and the rules of the grid."""
        return [
            table(frames[MAIN].rename(columns={"sees": "the state of the picture"})),
            "The grid is a torus: a step over one side comes back on the other. The goals have to be reached in their "
            "order. Distances are Manhattan distances on the torus; a direction is that of the longer axis, horizontal "
            "if both are equally long.",
        ]

    def _cell(self, place: tuple[int, int]) -> int:
        return (place[1] - 1) * self.size + place[0] - 1


@styled(font_size=10)
def _draw(
    seen: pd.DataFrame, title: str, size: int, agent: tuple[int, int], goals: Sequence[tuple[int, int]]
) -> Figure:
    """Draw the grid on the left, what is seen on the right."""
    figure, (grid, text) = plt.subplots(1, 2, figsize=(8, 4.6), layout="constrained", width_ratios=(3, 2))
    _draw_grid(grid, size)
    column, row = agent
    grid.add_patch(Circle((column, row), 0.42, color=BLUE, zorder=3))
    grid.annotate("agent", (column, row), ha="center", va="center", color="white", fontsize=7, zorder=4)
    tip = {"arrowstyle": "-|>", "color": BLUE, "linewidth": 1.5}
    for x, y in MOVES:
        head, tail = (column + 0.85 * x, row + 0.85 * y), (column + 0.3 * x, row + 0.3 * y)
        grid.annotate("", head, tail, arrowprops=tip)
    for number, (x, y) in enumerate(goals, 1):
        grid.add_patch(Rectangle((x - 0.36, y - 0.36), 0.72, 0.72, color=ORANGE, zorder=3))
        grid.annotate(f"g{number}", (x, y), ha="center", va="center", fontweight="bold", zorder=4)
    text.axis("off")
    for line, each in enumerate(seen.to_dict("records")):
        text.text(0.02, 0.8 - 0.24 * line, each["representation"], fontsize=12, fontweight="bold")
        text.text(0.02, 0.71 - 0.24 * line, each["sees"], fontsize=12)
    text.text(0.02, 0.02, "each with the success counter:\nhow many goals have been reached", fontsize=9)
    figure.suptitle(title, fontsize=12)
    return figure


def _draw_grid(axis: Axes, size: int) -> None:
    axis.set_xlim(0.5, size + 0.5)
    axis.set_ylim(size + 0.5, 0.5)
    axis.set_aspect("equal")
    axis.set_xticks(np.arange(0.5, size + 1), minor=True)
    axis.set_yticks(np.arange(0.5, size + 1), minor=True)
    axis.grid(which="minor", color="0.75")
    axis.set_xticks(range(1, size + 1))
    axis.set_yticks(range(1, size + 1))
    axis.tick_params(which="both", length=0)
    for side in axis.spines.values():
        side.set_linestyle((0, (4, 3)))  # open: it is a torus
