"""Layouts of stages: starts and goals as a period goes from one world to the next."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import IntArray
from rl_design_space.design import DesignPoint, StagePoint, World, cell_count
from rl_design_space.errors import ConfigError
from rl_design_space.learning.checked import places
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.learning.streams import below, layout_words

_Cells = NDArray[np.int32]


class StageScene(NamedTuple):
    """A stage as carry rules see it, see `design.Scene`."""

    world: World
    goals: NDArray[np.int32]
    codes: NDArray[np.int64]

    def period(self, number: int) -> StageScene:
        """Return the scene of one of the periods."""
        return StageScene(self.world, self.goals[number : number + 1], self.codes[number : number + 1])


class _Places(NamedTuple):
    """Start and goals of each period, (periods, 1 + n_goals) cells of a world, and how many layouts were drawn."""

    world: World
    cells: _Cells
    number: int


def stage_layouts(point: DesignPoint, stages: Sequence[StagePoint], periods: int | None = None) -> list[_Cells]:
    """Return start and goals of each period in each stage: (periods, 1 + n_goals) cell numbers, distinct in a row.

    The layout of the point is number 0; each `new` or `shifted` one draws from the stream of the next number, so it
    depends on seed, period, number and size alone. `scaled` leads from the places last drawn, or those of the point, to
    the cells that contain their centres.

    Args:
        point: the design point.
        stages: its stages.
        periods: number of periods, from the first; all if None.

    Raises:
        ConfigError: a world has too few open cells, or returns them in a wrong form, or `same` places are obstacles.
    """
    now = _Places(point.world, layouts_of(point, periods), 0)
    found = []
    for number, stage in enumerate(stages, 1):
        here, world, seed = stage.point, stage.point.world, point.seed
        if stage.layout == "new":
            now = _Places(world, layouts_of(here, periods, now.number + 1), now.number + 1)
        elif stage.layout == "shifted":
            moved = _shifted(now, layout_words(seed, len(now.cells), 1, now.number + 1)[:, 0])
            now = _Places(world, _settled(here, moved), now.number + 1)
        if stage.layout == "scaled":
            found.append(_settled(here, place_of(now.world, world)[now.cells]))
        else:
            if not np.isin(now.cells, places(here)).all():
                raise ConfigError(
                    f"curriculum: stage {number}: layout=same: a start or goal is an obstacle here; use new"
                )
            found.append(now.cells)
    return found


def place_of(origin: World, target: World) -> _Cells:
    """Return (cells of the origin,) the cell of another world that contains the centre of each cell."""
    (width, height), (new_width, new_height) = origin.shape, target.shape
    y, x = np.divmod(np.arange(cell_count(origin)), width)
    cells: IntArray = (2 * y + 1) * new_height // (2 * height) * new_width + (2 * x + 1) * new_width // (2 * width)
    return cells.astype(np.int32)


def _shifted(now: _Places, words: NDArray[np.uint64]) -> _Cells:
    """Return all places of a period moved by the same offset, round the border; never by none at all."""
    width, height = now.world.shape
    down, right = np.divmod(1 + below(words, width * height - 1), width)
    y, x = np.divmod(now.cells, width)
    moved: IntArray = (y + down[:, np.newaxis]) % height * width + (x + right[:, np.newaxis]) % width
    return moved.astype(np.int32)


def _settled(here: DesignPoint, wanted: _Cells) -> _Cells:
    """Return distinct open cells: of each wanted one that is taken or an obstacle, the nearest that is neither.

    Places are settled in their order, from the start to the last goal; of cells equally near, the first one is taken.
    """
    world, is_open = here.world, np.zeros(cell_count(here.world), dtype=np.bool_)
    is_open[places(here)] = True
    if is_open[wanted].all() and np.diff(np.sort(wanted, axis=1), axis=1).all():
        return wanted
    settled = np.empty_like(wanted)
    for place, cells in enumerate(wanted.T):
        settled[:, place] = cells
        taken = (settled[:, :place] == cells[:, np.newaxis]).any(axis=1) | ~is_open[cells]
        if taken.any():
            x, y = world.offset(cells[taken][:, np.newaxis])
            far = (np.abs(x) + np.abs(y))[:, 0].astype(np.float64)
            far[:, ~is_open] = np.inf
            np.put_along_axis(far, settled[taken, :place], np.inf, axis=1)
            settled[taken, place] = far.argmin(axis=1)
    return settled
