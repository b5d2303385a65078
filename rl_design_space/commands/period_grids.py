"""A period in the terminal: a grid of arrows for each success counter, coloured by value, with the path of a trial."""

from __future__ import annotations

from matplotlib.colors import Colormap, Normalize, to_hex
from rich.columns import Columns
from rich.console import Group, RenderableType
from rich.text import Text

from rl_design_space.design import MOVES
from rl_design_space.report.inside.grid import Grid
from rl_design_space.report.inside.picture import VALUES, told, value_norm
from rl_design_space.report.inside.watched import Watched

#: Right, left, above, below.
_ARROWS = "→←↑↓"
_MANY, _UNKNOWN, _OBSTACLE, _PATH = "+", "·", "█", "•"
_LEGEND = (
    f"arrows: greedy actions, {_MANY} several equal ones, {_UNKNOWN} never learned; {_PATH} on the path of the trial; "
    "S start, 1 2 … goals; red below zero, blue above"
)


def period_grids(watched: Watched) -> RenderableType:
    """Return the grids of a period side by side, as far as the terminal is wide."""
    norm, goals = value_norm((watched.snapshot,)), len(watched.inside.goals)
    grids = [
        Group(Text(f"to goal {goal + 1}" if goals > 1 else "to the goal", style="bold"), _grid(watched, goal, norm))
        for goal in range(goals)
    ]
    heading = Text(f"{watched.title}\n{told(watched.inside, watched.snapshot)}", style="bold")
    return Group(heading, Text(), Columns(grids, padding=(1, 3)), Text(_LEGEND, style="dim"))


def _grid(watched: Watched, goal: int, norm: Normalize, colours: Colormap = VALUES) -> Text:
    """Return the grid at a success counter: two characters a cell, what it is and whether the path leads over it."""
    inside, snapshot, grid = watched.inside, watched.snapshot, Grid(watched.inside.point)
    on_path = set(snapshot.path.cells[snapshot.path.counters == goal].tolist())
    places = {cell: str(number) for number, cell in enumerate(inside.goals, 1)}
    places |= {inside.start: "S"} if goal == 0 else {}
    text = Text(no_wrap=True)
    for cell in range(grid.width * grid.height):
        learned = bool(snapshot.learned[goal, cell])
        style = f"black on {to_hex(colours(norm(snapshot.values[goal, cell])))}" if learned else ""
        if cell == inside.goals[goal]:
            style = "bold black on #e69f00"
        elif cell in places:
            style = "bold black on white"
        if not grid.is_open[cell]:
            mark = _OBSTACLE
        elif cell in places:
            mark = places[cell][-1]
        else:
            mark = _mark(snapshot.greedy[goal, cell].nonzero()[0].tolist()) if learned else _UNKNOWN
        text.append(mark + (_PATH if cell in on_path else " "), style=style)
        if cell % grid.width == grid.width - 1:
            text.append("\n")
    return text


def _mark(actions: list[int]) -> str:
    """Return an arrow for greedy actions in one direction."""
    directions = {action % len(MOVES) for action in actions}
    return _ARROWS[directions.pop()] if len(directions) == 1 else _MANY
