"""What actions do: what observations show of the goals, controllers, and stops by perception."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from pydantic.dataclasses import dataclass

from rl_design_space.design import (
    MOVES,
    UNKNOWN,
    WAIT,
    AdHoc,
    Controllers,
    DesignPoint,
    Direct,
    Direction,
    Distance,
    MultiStepActions,
    Representation,
    SeeingActions,
    Sight,
    Task,
    Torus,
    Walled,
    cell_count,
)

RIGHT, LEFT, ABOVE, BELOW = range(4)
worlds = st.builds(lambda world, x, y: world(size=(x, y)), st.sampled_from([Torus, Walled]), *[st.integers(2, 6)] * 2)


@st.composite
def layouts(draw: st.DrawFn) -> tuple:
    """Draw a world and goals, all on different cells."""
    world = draw(worlds)
    cells = st.integers(0, cell_count(world) - 1)
    return world, np.array(draw(st.lists(cells, min_size=1, max_size=3, unique=True)))


def sight(representation, world, goals) -> Sight:
    return representation.sight(world, len(goals), representation.observation(world, goals))


directions = st.builds(
    Direction,
    rule=st.sampled_from(["dominant_axis", "horizontal_first"]),
    goals=st.sampled_from(["all", "remaining"]),
)


@given(layout=layouts(), representation=directions | st.sampled_from([Direct(), AdHoc(), Distance()]))
def test_what_is_shown_of_goals_is_true(layout: tuple, representation: Representation):
    world, goals = layout
    counter, cell = np.indices((len(goals), cell_count(world)))
    true_x, true_y = (np.sign(way)[:, np.newaxis] for way in world.offset(goals))
    shown = sight(representation, world, goals)
    assert (shown.counter == counter).all()
    assert ((shown.cell == cell) | (shown.cell == -1)).all()
    assert ((shown.x == true_x) | (shown.x == UNKNOWN)).all()
    assert ((shown.y == true_y) | (shown.y == UNKNOWN)).all()


def test_a_representation_shows_no_more_and_no_less_than_it_says():
    world, goals = Torus(size=5), np.array([12, 3])
    everything = sight(Direct(), world, goals)
    assert UNKNOWN not in everything.x
    assert (everything.cell == np.arange(25)).all()
    directions = sight(Direction(), world, goals)
    # Of one cell in four or fewer of each offset both signs are known: on the goal itself.
    assert ((directions.x == UNKNOWN) ^ (directions.y == UNKNOWN))[1, 1, np.arange(25) != 3].all()
    assert (directions.x[0, 1] == UNKNOWN).all()  # reached, and no longer observed
    assert UNKNOWN in sight(Direction(goals="all"), world, goals).y[0, 1]
    assert not (sight(Direction(goals="all"), world, goals).x[0, 1] == UNKNOWN).all()
    columns = sight(Direction(rule="horizontal_first"), world, goals)
    assert (columns.x[0, 0] != UNKNOWN).all()
    assert (sight(AdHoc(), world, goals).x == UNKNOWN).all()
    assert (sight(Distance(), world, goals).cell == -1).all()


@given(layout=layouts())
def test_with_all_shown_a_controller_leads_level_with_the_due_goal(layout: tuple):
    world, goals = layout
    codes = Direct().observation(world, goals)
    found = Controllers(primitives=False).behaviour(world, Direct(), goals, codes)
    table = [*world.next_cell().tolist(), list(range(cell_count(world)))]
    for due, goal in enumerate(goals.tolist()):
        for axis in (0, 1):
            ways = np.abs(world.offset(np.array([goal]))[axis][0])
            for start in range(cell_count(world)):
                cell, steps = start, 0
                while not found.stops[axis, due, cell]:
                    cell = table[found.steps[axis, due, cell]][cell]
                    steps += 1
                assert steps == ways[start]
                assert ways[cell] == 0


def controller(name: str, representation, world, goals: list[int]) -> tuple[list, list]:
    """Return steps and stops of a controller at every success counter and cell."""
    codes = representation.observation(world, np.array(goals))
    msa = Controllers(controllers=(name,))
    found = msa.behaviour(world, representation, np.array(goals), codes)
    return found.steps[4].tolist(), found.stops[4].tolist()


def test_with_directions_a_controller_goes_as_far_as_it_sees():
    # The goal is in the middle; from the cell at the upper left both axes are equally far, so it is seen to the right.
    steps, stops = controller("goal_along_x", Direction(), Walled(size=3), [4])
    assert steps == [[RIGHT, WAIT, LEFT, RIGHT, WAIT, LEFT, RIGHT, WAIT, LEFT]]
    assert stops == [[step == WAIT for step in steps[0]]]
    assert controller("goal_along_y", Direction(), Walled(size=3), [4])[0] == [
        [WAIT, BELOW, WAIT, WAIT, WAIT, WAIT, WAIT, ABOVE, WAIT]
    ]


def test_along_the_wall_with_the_wall_on_the_right_hand_up_to_the_next_turn():
    steps, stops = controller("along_wall", Direct(), Walled(size=(4, 3)), [5])
    assert np.reshape(steps, (3, 4)).tolist() == [
        [BELOW, LEFT, LEFT, LEFT],
        [BELOW, WAIT, WAIT, ABOVE],
        [RIGHT, RIGHT, RIGHT, ABOVE],
    ]
    assert np.reshape(stops, (3, 4)).tolist() == [
        [True, False, False, True],
        [False, True, True, False],
        [True, False, False, True],
    ]


def test_back_to_the_goal_reached_last_where_it_is_shown():
    world = Walled(size=3)
    steps, _ = controller("back_to_sub_goal", Direct(), world, [4, 0])
    assert steps[0] == [WAIT] * 9  # none is reached yet
    assert steps[1] == [RIGHT, BELOW, LEFT, RIGHT, WAIT, LEFT, RIGHT, ABOVE, LEFT]
    assert controller("back_to_sub_goal", Direction(goals="all"), world, [4, 0])[0][1] == steps[1]
    assert controller("back_to_sub_goal", Direction(), world, [4, 0])[0][1] == [WAIT] * 9


BACK = Controllers(controllers=("back_to_sub_goal",))


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        ({"representation": AdHoc()}, "goal_along_x would never move: AdHoc with 3 goals in Torus does not show"),
        ({"representation": Distance()}, "goal_along_x would never move"),
        (
            {"msa": Controllers(controllers=("along_wall",))},
            "along_wall would never move: Direct with 3 goals in",
        ),
        (
            {"msa": Controllers(controllers=("back_to_sub_goal",)), "task": Task(goals=1)},
            "back_to_sub_goal would never",
        ),
        (
            {"msa": Controllers(controllers=("back_to_sub_goal",)), "representation": Direction()},
            "the goal reached last",
        ),
    ],
)
def test_a_controller_that_the_observation_shows_nothing_is_refused(choices: dict, message: str):
    with pytest.raises(ValidationError, match=message):
        DesignPoint(**{"representation": Direct(), "msa": Controllers(), **choices})


@dataclass(frozen=True, kw_only=True)
class OwnActions(SeeingActions):
    """Actions that are no controllers: towards the due goal along x, and to the right whatever is shown."""

    names = ("homing", "right")

    def moves(self, sight: Sight) -> np.ndarray:
        x, _ = sight.due_goal()
        return np.array([np.select([x == 1, x == -1], [RIGHT, LEFT], WAIT), np.full(x.shape, RIGHT)], dtype=np.int8)


def test_an_action_of_an_own_set_that_would_wait_everywhere_is_refused():
    DesignPoint(representation=Direct(), msa=OwnActions())
    with pytest.raises(ValidationError, match="OwnActions: homing would never move: AdHoc with 3 goals in Torus"):
        DesignPoint(representation=AdHoc(), msa=OwnActions(primitives=False))


@pytest.mark.parametrize("controllers", [(), ("along_wall",)])
def test_a_set_of_fewer_than_two_actions_is_refused(controllers: tuple):
    with pytest.raises(ValidationError, match="primitives=false: fewer than two actions are left"):
        Controllers(controllers=controllers, primitives=False)


def test_stops_by_perception_look_at_the_whole_observation_or_at_the_due_goal_alone():
    world, goals = Torus(size=5), np.array([[12, 3]])
    representation = Direction(goals="all")
    codes = representation.observation(world, goals)
    whole = MultiStepActions(lengths=(3,), until="observation_changes").behaviour(world, representation, goals, codes)
    assert whole.marks.tolist() == codes.tolist()
    due = MultiStepActions(lengths=(3,), until="due_goal_observation_changes")
    alone = due.behaviour(world, representation, goals, codes).marks
    digits = codes % 5, codes // 5 % 5
    assert alone.tolist() == [[digits[0][0, 0].tolist(), digits[1][0, 1].tolist()]]
    assert (whole.steps.reshape(8, -1) == np.arange(8)[:, np.newaxis] % len(MOVES)).all()
