"""Figure 1: the scenario drawn, with the representations of the state that it shows."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.design import MOVES, Direction, Distance, Torus
from rl_design_space.errors import ConfigError

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.read import Reader

Cell = Annotated[tuple[int, int], Field(strict=False)]
#: What a direction is called, by the code of a world with one goal.
_DIRECTIONS = ("here", "right", "left", "above", "below")
_ALT = (
    "A grid with an agent and numbered goals, the four moves, and the same state as it is seen by the ad hoc, distance "
    "and direction representations"
)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Scenario:
    """An agent and its goals on a torus.

    Attributes:
        title: of the figure.
        size: side of the grid.
        agent: its column and row, from 1, counted from the upper left.
        goals: columns and rows of the goals in their order.
    """

    title: Annotated[str, Field(min_length=1)]
    size: Annotated[int, Field(ge=2)]
    agent: Cell
    goals: Annotated[tuple[Cell, ...], Field(strict=False, min_length=1)]

    def frame(self) -> pd.DataFrame:
        """What each representation sees in this state: a row a representation."""
        import pandas as pd

        for column, row in (self.agent, *self.goals):
            if not (1 <= column <= self.size and 1 <= row <= self.size):
                raise ConfigError(f"study.report: ({column}, {row}) lies outside of a grid of {self.size}×{self.size}")
        world = Torus(size=self.size)
        goals = np.array([self._cell(goal) for goal in self.goals], dtype=np.int32)
        agent = self._cell(self.agent)
        alone = goals[:, np.newaxis]  # one layout a goal: the code then is that goal's share alone
        distances = Distance().observation(world, alone)[:, 0, agent].tolist()
        directions = Direction().observation(world, alone)[:, 0, agent].tolist()
        seen = {
            "ad hoc": f"({', '.join(map(str, self.agent))})",
            "distance": f"({', '.join(map(str, distances))})",
            "direction": f"({', '.join(_DIRECTIONS[code] for code in directions)})",
        }
        return pd.DataFrame({"representation": list(seen), "sees": list(seen.values())})

    def draw(self) -> Figure:
        """The grid on the left, what is seen on the right."""
        import matplotlib as mpl

        mpl.use("Agg")
        import matplotlib.pyplot as plt

        settings: dict[Any, Any] = {"svg.hashsalt": "rl-design-space", "svg.fonttype": "none", "font.size": 10}
        with mpl.rc_context(settings):
            figure, (grid, text) = plt.subplots(1, 2, figsize=(8, 4.6), layout="constrained", width_ratios=(3, 2))
            _draw_grid(grid, self.size)
            column, row = self.agent
            grid.plot(column, row, marker="o", markersize=26, color="#0072b2", zorder=3)
            grid.annotate("agent", (column, row), ha="center", va="center", color="white", fontsize=7, zorder=4)
            for x, y in MOVES:
                tip = {"arrowstyle": "-|>", "color": "#0072b2", "linewidth": 1.5}
                grid.annotate(
                    "", (column + 0.85 * x, row + 0.85 * y), (column + 0.3 * x, row + 0.3 * y), arrowprops=tip
                )
            for number, (x, y) in enumerate(self.goals, 1):
                grid.plot(x, y, marker="s", markersize=22, color="#e69f00", zorder=3)
                grid.annotate(f"g{number}", (x, y), ha="center", va="center", fontweight="bold", zorder=4)
            text.axis("off")
            for line, seen in enumerate(self.frame().to_dict("records")):
                text.text(0.02, 0.8 - 0.24 * line, seen["representation"], fontsize=12, fontweight="bold")
                text.text(0.02, 0.71 - 0.24 * line, seen["sees"], fontsize=12)
            text.text(0.02, 0.02, "each with the success counter:\nhow many goals have been reached", fontsize=9)
            figure.suptitle(self.title, fontsize=12)
        return figure

    def write(self, study: Study, reader: Reader, folder: Path) -> list[Path]:
        """Write NAME.png, .svg, .csv and .md into a folder; the paths written."""
        from rl_design_space.report.heatmap import save
        from rl_design_space.report.markdown import made_by

        seen = self.frame()
        folder.mkdir(parents=True, exist_ok=True)
        stem = folder / study.name
        paths = save(self.draw(), stem)
        seen.to_csv(stem.with_suffix(".csv"), index=False)
        lines = [
            f"# {self.title}",
            "",
            f"![{_ALT}]({study.name}.png)",
            "",
            made_by(study),
            "",
            "| representation | the state of the picture |",
            "|---|---|",
            *(f"| {row.representation} | {row.sees} |" for row in seen.itertuples()),
            "",
            "The grid is a torus: who leaves it on one side comes back on the other. The goals have to be reached in "
            "their order. Distances are Manhattan distances on the torus; a direction is that of the longer axis, "
            "horizontal if both are equally long.",
            "",
        ]
        stem.with_suffix(".md").write_text("\n".join(lines), encoding="utf-8")
        return [*paths, stem.with_suffix(".csv"), stem.with_suffix(".md")]

    def _cell(self, place: tuple[int, int]) -> int:
        return (place[1] - 1) * self.size + place[0] - 1


def _draw_grid(axis: Any, size: int) -> None:
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
