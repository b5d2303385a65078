"""Random design points, small enough for the reference implementation, and random results."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from rl_design_space.design import (
    ActionSet,
    AdHoc,
    Aggregated,
    Constant,
    DesignPoint,
    Direct,
    Direction,
    Distance,
    Exponential,
    GoalReward,
    Linear,
    MultiStepActions,
    QLearning,
    Sigmoidal,
    Stage,
    Stages,
    Task,
    Torus,
    Walled,
    World,
)
from rl_design_space.learning import LearningCurves
from tests.learning.scrambled import ScrambledActions

probabilities = st.floats(0, 1)
observed_goals = st.sampled_from(["all", "remaining", "due"])
sides = st.integers(2, 5)
worlds = st.builds(lambda world, dx, dy: world(size=(dx, dy)), st.sampled_from([Torus, Walled]), sides, sides)

representations = st.one_of(
    st.just(AdHoc()),
    st.just(Direct()),
    st.builds(Distance, goals=observed_goals),
    st.builds(Direction, rule=st.sampled_from(["dominant_axis", "horizontal_first"]), goals=observed_goals),
)

first_trials = st.integers(0, 3)
explorations = st.one_of(
    st.builds(Constant, epsilon=st.sampled_from([0.0, 0.1, 1.0]) | probabilities),
    st.builds(Linear, start=probabilities, k=st.floats(0, 0.5), first_trial=first_trials),
    st.builds(Exponential, start=probabilities, l=st.floats(0.5, 10), first_trial=first_trials),
    st.builds(Sigmoidal, p=st.floats(0.1, 10), q=st.floats(-5, 10), first_trial=first_trials),
)

#: No more than two sets: the kernel is compiled again for every number of action lengths.
multi_step_actions = st.builds(
    MultiStepActions,
    lengths=st.lists(st.integers(2, 6), max_size=2, unique=True).map(tuple),
    propagation=st.sampled_from(["primitives", "all_shorter", "none"]),
    reward=st.sampled_from(["realised", "printed"]),
    sub_goal=st.sampled_from(["continue", "stop"]),
)

#: With four actions beside the primitive ones, as sets that are scrambled.
seeing_multi_step_actions = st.builds(
    MultiStepActions,
    lengths=st.integers(2, 6).map(lambda length: (length,)),
    propagation=st.sampled_from(["primitives", "all_shorter", "consistent", "none"]),
    reward=st.sampled_from(["realised", "printed"]),
    sub_goal=st.sampled_from(["continue", "stop"]),
    until=st.sampled_from(["length", "observation_changes", "due_goal_observation_changes"]),
)
#: Six actions, which take up eight values in a row of the Q-matrix.
scrambled_actions = st.builds(
    ScrambledActions,
    salt=st.integers(0, 2**32),
    own=st.sampled_from([2, 6]),
    limit=st.integers(1, 6),
    propagation=st.sampled_from(["primitives", "consistent", "none"]),
    reward=st.sampled_from(["realised", "printed"]),
    sub_goal=st.sampled_from(["continue", "stop"]),
)

amounts = st.floats(-10, 10)
many_rewards, each_success, end_reward = GoalReward(), GoalReward(step=0.0), GoalReward(step=0.0, sub_goal=0.0)
rewards = st.sampled_from([many_rewards, each_success, end_reward]) | st.builds(
    GoalReward, step=amounts, sub_goal=amounts, final_goal=amounts
)

learners = st.builds(
    QLearning,
    alpha=st.sampled_from([0.1, 1.0]) | st.floats(0.01, 1),
    gamma=st.sampled_from([0.0, 0.9, 1.0]) | probabilities,
    initial_q=st.sampled_from([0.0, -2.0, 5.0]) | amounts,
    explore=st.sampled_from(["non_greedy", "all"]),
    ties=st.sampled_from(["random", "first"]),
    out_of_order=st.sampled_from(["step_reward", "zero"]),
    update=st.sampled_from(["standard", "printed"]),
)


def aggregated(world: World) -> st.SearchStrategy[Aggregated]:
    """Draw blocks that divide a world."""
    sides = (st.sampled_from([side for side in range(1, size + 1) if size % side == 0]) for size in world.shape)
    return st.builds(Aggregated, block=st.tuples(*sides))


@st.composite
def points(
    draw: st.DrawFn,
    actions: st.SearchStrategy[ActionSet] = multi_step_actions,
    blocks: Callable[[World], st.SearchStrategy[Aggregated]] = aggregated,
) -> DesignPoint:
    """Draw any combination of options and readings; the step cap is often met, also within a multi-step action."""
    world = draw(worlds)
    width, height = world.shape
    task = Task(
        goals=draw(st.integers(1, min(4, width * height - 1))),
        trials=draw(st.integers(1, 6)),
        # Few and many side by side, and more than there are lanes.
        periods=draw(st.integers(1, 3) | st.sampled_from([5, 9, 26])),
        max_steps=draw(st.integers(1, 60)),
    )
    return DesignPoint(
        seed=draw(st.integers(0, 2**64 - 1)),
        task=task,
        world=world,
        representation=draw(representations | blocks(world)),
        exploration=draw(explorations),
        msa=draw(actions),
        reward=draw(rewards),
        learner=draw(learners),
    )


tabulated_points = points(seeing_multi_step_actions | scrambled_actions)


@st.composite
def results(draw: st.DrawFn, point: DesignPoint) -> LearningCurves:
    """Draw results of a point, of any shape, with steps around the limits of 16 and 32 bits."""
    periods, trials = shape = draw(array_shapes(min_dims=2, max_dims=2, max_side=6))
    steps = st.integers(1, 9) | st.sampled_from([65_535, 65_536, 2**31 - 1])
    return LearningCurves(
        steps=draw(arrays(np.int32, shape, elements=steps)),
        success=draw(arrays(np.bool_, shape)),
        optimum=draw(arrays(np.int32, periods, elements=st.integers(1, 9))),
        rows=draw(arrays(np.int32, (periods, 2), elements=st.integers(0, 99))),
        epsilon=draw(arrays(np.float64, trials, elements=st.floats(0, 1))),
        seconds=draw(st.floats(1e-3, 1e6)),
        known_point=point,
    )


@st.composite
def staged_points(draw: st.DrawFn) -> DesignPoint:
    """Draw a point of one to four stages, which differ in anything that stages can differ in."""
    point = draw(points(blocks=lambda world: st.nothing()))
    goals, places, found = point.task.goals, point.world, list[Stage]()
    representation, msa = point.representation, point.msa
    for _ in range(draw(st.integers(1, 4))):
        changes: dict[str, object] = {
            "task.trials": draw(st.integers(1, 4)),
            "task.max_steps": draw(st.integers(1, 60)),
        }
        layout = draw(st.sampled_from(["same", "scaled", "new", "shifted"]))
        carry = draw(st.sampled_from(["same_observation", "same_observation", "same_place", "none"]))
        world = draw(worlds.filter(lambda world: world.shape[0] * world.shape[1] > goals))
        if layout in ("same", "shifted"):
            world = draw(st.sampled_from([Torus, Walled]))(size=places.shape)
        if draw(st.booleans()) or layout in ("scaled", "new"):
            changes["world"] = world
        else:
            world = point.world
        if layout in ("same", "shifted") and world.shape != places.shape:
            changes["world"] = world = Torus(size=places.shape)
        places = world if layout == "new" else places
        if carry != "same_observation" and found and draw(st.booleans()):
            representation = draw(representations)
        if carry == "none" and found and draw(st.booleans()):
            msa = draw(multi_step_actions)
        changes |= {"representation": representation, "msa": msa}
        if draw(st.booleans()):
            changes |= {"learner": draw(learners), "exploration": draw(explorations), "reward": draw(rewards)}
        if draw(st.booleans()):
            changes["learner.alpha"] = 0.0
        found.append(Stage(changes=changes, layout=layout, carry=carry))
    return replace(point, curriculum=Stages(stages=tuple(found)))
