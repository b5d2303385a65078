"""Cells in blocks: codes by hand, what fits a world, and the block of one cell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rl_design_space.design import AdHoc, Aggregated, DesignPoint, Stage, Stages, Task, Torus, Walled
from rl_design_space.learning import simulate

POINT = DesignPoint(task=Task(goals=2, trials=8, periods=20), world=Torus(size=(6, 4)))


def test_cells_of_a_block_share_a_code_at_each_counter_wherever_the_goals_are():
    codes = Aggregated(block=(3, 2)).observation(POINT.world, np.array([[0, 7], [13, 4]]))
    blocks = np.array([[0, 0, 0, 1, 1, 1]] * 2 + [[2, 2, 2, 3, 3, 3]] * 2).ravel()
    np.testing.assert_array_equal(codes, [[blocks, blocks + 4]] * 2)


@pytest.mark.parametrize("world", [Torus(size=(6, 4)), Walled(size=5)], ids=str)
def test_blocks_of_one_cell_are_ad_hoc(world):
    ad_hoc, blocks = (
        simulate(replace(POINT, world=world, representation=each)) for each in (AdHoc(), Aggregated(block=1))
    )
    np.testing.assert_array_equal(blocks.steps, ad_hoc.steps)
    np.testing.assert_array_equal(blocks.rows, ad_hoc.rows)


def test_a_period_has_as_many_rows_as_blocks_times_goals():
    curves = simulate(replace(POINT, representation=Aggregated(block=[3, 2])))
    assert (curves.rows[:, 0] == 4 * 2).all()


@pytest.mark.parametrize(
    ("world", "block", "message"),
    [
        (Torus(size=10), 3, "representation.block=3: does not divide the 10×10 world; sides that do are 1, 2, 5, 10"),
        (
            Walled(size=(6, 4)),
            (3, 3),
            r"representation.block=\[3, 3\]: does not divide the 6×4 world; sides that do are 1, 2, 3, 6 along x and "
            "1, 2, 4 along y",
        ),
    ],
)
def test_a_block_that_does_not_fit_is_refused(world, block, message):
    with pytest.raises(ValueError, match=message):
        DesignPoint(world=world, representation=Aggregated(block=block))


def test_a_stage_may_change_world_and_block_together():
    wider = Stage.of({"representation.block": 3, "world.size": 9, "layout": "scaled"})
    stages = Stages(stages=(Stage(), replace(wider, carry="same_place")))
    point = DesignPoint(representation=Aggregated(block=5), curriculum=stages)
    assert point.curriculum.stage_list()[1].applied(point).representation == Aggregated(block=3)
