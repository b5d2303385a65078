"""Stages that split blocks: agreement with the reference, budgets of rows, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl_design_space.design import (
    Aggregated,
    DesignPoint,
    Direction,
    MultiStepActions,
    NewGoals,
    Refine,
    Refinement,
    Stage,
    Stages,
    Task,
    Torus,
    Walled,
    stages_of,
)
from rl_design_space.learning import simulate
from rl_design_space.learning.refining import refine_into
from rl_design_space.learning.td_errors import Errors, no_errors
from tests.learning import strategies
from tests.learning.test_stages import assert_agrees

POINT = DesignPoint(
    seed=3,
    task=Task(goals=2, trials=6, periods=5, max_steps=300),
    world=Torus(size=6),
    representation=Aggregated(block=3),
)
ALL = {"refine": "all", "carry": "same_place"}


def of(*stages: dict[str, object]) -> DesignPoint:
    """Return the point with these stages."""
    return replace(POINT, curriculum=Stages(stages=tuple(Stage.of(stage) for stage in stages)))


refinements = st.builds(
    Refinement,
    split=st.sampled_from(["disagreeing", "disagreeing", "all", "none"]),
    rows=st.none() | st.integers(1, 40),
)


@st.composite
def refined_points(draw: st.DrawFn) -> DesignPoint:
    """Draw a point that splits blocks one to three times."""
    point = draw(strategies.points())
    width, height = point.world.shape
    sides = [draw(st.sampled_from([side for side in range(1, n + 1) if n % side == 0])) for n in (width, height)]
    stages = [Stage()]
    for _ in range(draw(st.integers(1, 3))):
        layout = draw(st.sampled_from(["same", "new", "shifted"]))
        carry = draw(st.sampled_from(["same_place", "same_place", "none"]))
        changes = {"learner.alpha": draw(st.sampled_from([0.1, 1.0]))}
        stages.append(Stage(changes=changes, layout=layout, carry=carry, refine=draw(refinements)))
    blocks = Aggregated(block=tuple(sides))
    # One kernel for all: that of primitive actions.
    return replace(point, representation=blocks, msa=MultiStepActions(), curriculum=Stages(stages=tuple(stages)))


@settings(deadline=None, max_examples=20)
@given(point=refined_points())
def test_steps_success_and_rows_agree_with_the_reference(point: DesignPoint):
    assert_agrees(point)


@pytest.mark.parametrize("split", ["disagreeing", "all"])
def test_the_curriculum_agrees_and_keeps_to_its_rows(split: str):
    point = replace(POINT, curriculum=Refine(split=split, rows=30, times=3, trials=4))
    assert_agrees(point)
    rows = np.array([stage.rows[:, 0] for stage in simulate(point, threads=1).stages])
    assert (rows[0] == 8).all()
    assert (np.diff(rows, axis=0) >= 0).all()
    assert (rows[-1] > 27).all()
    assert (rows[-1] <= 30).all()


def test_splitting_all_again_and_again_leads_to_single_cells():
    curves = simulate(of({}, ALL, ALL, ALL), threads=1)
    # Blocks of 3×3 cells, then of 2 and 1, then of 1.
    assert [stage.rows[0, 0] for stage in curves.stages] == [2 * 4, 2 * 16, 2 * 36, 2 * 36]
    assert all((stage.carried == stage.rows[:, 0]).all() for stage in curves.stages[1:])


def test_blocks_that_stay_as_they_are_go_on():
    halves = of({"task.trials": 4}, {"task.trials": 2, "refine": "none", "carry": "same_place"})
    np.testing.assert_array_equal(simulate(halves).steps, simulate(POINT).steps)
    refined = of({"task.trials": 3}, {"task.trials": 6, **ALL})
    going_on = of(
        {"task.trials": 3}, {"task.trials": 4, **ALL}, {"task.trials": 2, "refine": "none", "carry": "same_place"}
    )
    np.testing.assert_array_equal(simulate(going_on).steps, simulate(refined).steps)


def test_threads_do_not_change_results():
    point = replace(POINT, curriculum=Refine(rows=30, trials=4), task=replace(POINT.task, periods=30))
    np.testing.assert_array_equal(simulate(point, threads=2).steps, simulate(point, threads=1).steps)


def split(sums: list[list[float]], counts: list[list[int]], rows: int | None = None) -> list[int]:
    """Split two blocks of 2×2 cells side by side, with two actions; return the code of each cell."""
    before = np.array([[[0, 0, 1, 1, 0, 0, 1, 1]]])
    errors = Errors(np.array([sums]), np.array([counts], dtype=np.int32))
    codes = np.empty_like(before)
    refine_into(codes, before, 4, Refinement(rows=rows), errors)
    return codes[0, 0].tolist()


def test_blocks_are_split_whose_cells_disagree_the_most_first():
    agree, counts = [[-0.2, 0.3]] * 8, [[2, 3]] * 8
    assert split(agree, counts) == [0, 0, 2, 2, 0, 0, 2, 2]
    # Cells without an error of an action do not count: here each action was executed in one cell of the block.
    nothing = [[0, 0]] * 8
    assert split([[5.0, 0.0], [0.0, -1.0], *[[0.0, 0.0]] * 6], [[4, 0], [0, 1], *nothing[2:]]) == [0, 0, 2, 2] * 2
    some = [[-0.2, 0.3]] * 7 + [[-0.2, 0.9]]
    assert split(some, counts) == [0, 0, 2, 3, 0, 0, 6, 7]
    more = [[-0.7, 0.3], *some[1:]]
    assert split(more, counts) == [0, 1, 2, 3, 4, 5, 6, 7]
    # Cells 0 and 7 differ by 0.5 and 0.6 in two and three steps.
    assert split(more, counts, rows=5) == [0, 1, 2, 2, 4, 5, 2, 2]
    assert split(more, counts, rows=4) == [0, 0, 2, 2, 0, 0, 2, 2]


def test_no_errors_are_collected_unless_they_are_asked_for():
    assert no_errors(0, 9, 4).sums.size == 0


@pytest.mark.parametrize(
    ("stages", "message"),
    [
        ([ALL], "stage 1: refine=all: there is no stage before the first one"),
        ([{}, {"refine": "all"}], "stage 2: carry=same_observation, refine=all: the parts of a block are new"),
        ([{}, ALL, {}], "stage 3: carry=same_observation: the stage before observes other blocks"),
        ([{}, {**ALL, "representation.block": 2}], "refine=all: splits the blocks of the stage before"),
        (
            [{"learner.alpha": 0}, {"refine": {"rows": 9}, "carry": "same_place"}],
            r"refine=disagreeing: the stage before learns nothing \(learner.alpha=0\)",
        ),
        (
            [{}, {**ALL, "msa": MultiStepActions(lengths=(3,), until="observation_changes")}],
            "actions that depend on observations do not know the parts of blocks",
        ),
        ([{}, {"refine": "some", "carry": "same_place"}], "refine=some: should be 'disagreeing', 'all' or 'none'"),
        ([{}, {"refine": {"row": 7}, "carry": "same_place"}], "row"),
    ],
)
def test_what_cannot_be_refined_is_refused(stages, message):
    with pytest.raises(ValueError, match=message):
        of(*stages)


def test_only_blocks_can_be_split():
    with pytest.raises(ValueError, match="refine=disagreeing: splits blocks, and Direction has none"):
        replace(POINT, representation=Direction(), curriculum=Refine())
    with pytest.raises(ValueError, match="refine=all: splits the blocks of the stage before, so representation"):
        of({}, {**ALL, "world": Walled(size=3), "layout": "scaled"})


def test_stages_without_blocks_to_split_are_described_as_before():
    assert [stage.refine for stage in stages_of(replace(POINT, curriculum=NewGoals()))] == [None] * 5
    assert Stage().as_node() == {}
    assert Stage.of(ALL).as_node() == {"carry": "same_place", "refine": {"split": "all", "rows": None}}
    assert Stage.of(Stage.of(ALL).as_node()) == Stage.of(ALL)
