"""Contracts of components: what every option guarantees, those of the package and your own.

Each check takes a built component and raises an AssertionError that names the breach:

    from rl_design_space.contracts import check_representation

    def test_my_representation():
        check_representation(MyRepresentation(radius=2))

Shapes, types and ranges are those that learning itself insists on, see `learning.checked`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from rl_design_space._arrays import FloatArray, IntArray
from rl_design_space.design import (
    ActionSet,
    AdHoc,
    Aggregated,
    AttributedRepresentation,
    CarryRule,
    ClosedLoop,
    Counters,
    Curriculum,
    DesignPoint,
    Direct,
    Direction,
    Exploration,
    MultiStepActions,
    PotentialReward,
    Representation,
    Reward,
    SizedRepresentation,
    Slip,
    Stage,
    StochasticWorld,
    TabularLearner,
    Task,
    Torus,
    TransitionReward,
    Walled,
    Without,
    World,
    cell_count,
    possible_cells,
)
from rl_design_space.design.demands import check_layouts, check_value, expect, layouts, repeatable
from rl_design_space.design.identity import function_name
from rl_design_space.design.ways import missing_way
from rl_design_space.errors import ConfigError
from rl_design_space.learning import checked
from rl_design_space.learning.stage_layouts import StageScene

__all__ = [
    "check_carry",
    "check_curriculum",
    "check_exploration",
    "check_learner",
    "check_msa",
    "check_representation",
    "check_reward",
    "check_study",
    "check_world",
]

_WORLDS: tuple[World, ...] = (Torus(size=4), Torus(size=(5, 3)), Walled(size=(2, 4)))
_TRIALS = (1, 2, 7, 100)
#: Representations that show much, little, and nothing of the goals.
_SIGHTED: tuple[Representation, ...] = (Direct(), Direction(), Direction(goals="all"), AdHoc())
#: What a closed loop is asked, and a task that is learned in no time.
_COUNTERS = tuple(
    Counters(trial, level, successes, succeeded, 50, error)
    for trial, level, successes, succeeded, error in ((1, 1.0, 0, 0, 3.0), (1, 0.9, 1, 1, 0.0), (9, 0.1, 5, 0, 1e6))
)
_SHORT = Task(goals=2, trials=10, periods=2, max_steps=200)
#: Number of goals whose offsets are checked: all cells of a small world, a sample of a large one.
_MOST_GOALS = 64


def check_world(world: World) -> None:
    """Check shape, transitions or outcomes, open cells, offsets and reach of a world, and that no cell is cut off."""
    check_value(world, World)
    for name, pair in (("shape", world.shape), ("reach", world.reach)):
        whole = isinstance(pair, tuple) and [type(side) for side in pair] == [int, int]
        expect(whole and min(pair) >= (name == "shape"), f"{name} must be two whole numbers, along x and y: {pair}")
    point = DesignPoint(world=world, task=Task(goals=1))
    table = repeatable("next_cell()", partial(checked.transitions, point))
    cells = repeatable("open_cells()", partial(checked.places, point))
    method = "next_cell()"
    if isinstance(world, StochasticWorld):
        method = "outcomes()"
        repeatable(method, lambda: np.concatenate(checked.outcomes(point) or world.outcomes(), axis=-1))
        table = possible_cells(checked.outcomes(point) or world.outcomes())
    missing = missing_way(table, cells)
    expect(missing is None, f"{method} must lead from every open cell to every other, but it does not: {missing}")
    if isinstance(world, StochasticWorld):
        from rl_design_space.learning.optimum import expected_steps  # late: it imports Numba

        expect(
            bool(np.isfinite(expected_steps(world.outcomes(), cells)[:, cells]).all()),
            "outcomes() must let a policy reach every open cell from every other with certainty, not only by luck",
        )

    for axis, name in enumerate("xy"):
        check_layouts(f"offset() along {name}", partial(_offset, world, axis), cell_count(world))
    goals = np.unique(np.linspace(0, cell_count(world) - 1, _MOST_GOALS).astype(np.int32))
    x, y = world.offset(goals)
    at_goal = goals[:, np.newaxis] == np.arange(cell_count(world))
    expect(np.array_equal((x == 0) & (y == 0), at_goal), "offset() must be (0, 0) at the goal and nowhere else")
    farthest = int(np.abs(x).max()), int(np.abs(y).max())
    within = farthest[0] <= world.reach[0] and farthest[1] <= world.reach[1]
    expect(within, f"offset() must lie within reach {world.reach}, but goes as far as {farthest}")


def check_representation(representation: Representation, worlds: Sequence[World] = _WORLDS) -> None:
    """Check the codes of a representation, for layouts of one to three goals in each of these worlds that it fits."""
    check_value(representation, Representation)
    fitting = [
        point
        for world in worlds
        for n_goals in range(1, 1 + min(3, cell_count(world) - 1))
        if (point := _fitting(MultiStepActions(), representation, world, n_goals))
    ]
    expect(bool(fitting), f"{type(representation).__name__} must fit one of the worlds {', '.join(map(str, worlds))}")
    for point in fitting:
        world, n_goals = point.world, point.task.goals
        table = partial(checked.observation_codes, point)
        codes = check_layouts("observation()", table, cell_count(world), n_goals)
        if isinstance(representation, SizedRepresentation):
            size = representation.spanned_size(world, n_goals)
            expect(int(codes.max()) < size, f"observation() codes must be less than spanned_size() = {size}")
            published = representation.published_size(world, n_goals)
            expect(type(published) is int and published > 0, "published_size() must be a positive whole number")
        if isinstance(representation, AttributedRepresentation):
            every = Without(of=representation).observation(world, layouts(cell_count(world), n_goals))
            both = np.stack([codes.ravel(), every.ravel()])
            same = len({np.unique(each, axis=1).shape[1] for each in (both[:1], both[1:], both)}) == 1
            expect(same, "attributes() together must tell apart what observation() does")


def check_exploration(exploration: Exploration) -> None:
    """Check length, type and range of a schedule, for several numbers of trials."""
    check_value(exploration, Exploration)
    for trials in _TRIALS:
        point = DesignPoint(exploration=exploration, task=Task(trials=trials))
        repeatable(f"schedule({trials})", partial(checked.epsilons, point))
    if isinstance(exploration, ClosedLoop):
        for counters in _COUNTERS:
            epsilon = exploration.rule(counters, exploration.parameters)
            expect(0 <= epsilon <= 1, f"rule() must give ε from 0 to 1, but gives {epsilon} after {counters}")
        _learned(DesignPoint(exploration=exploration, world=Torus(size=4), task=_SHORT))


def check_learner(learner: TabularLearner) -> None:
    """Check that a learner is compiled, learns the same at every call, and keeps all values finite."""
    check_value(learner, TabularLearner)
    _learned(DesignPoint(learner=learner, world=Torus(size=4), task=_SHORT))


def _learned(point: DesignPoint) -> None:
    """Check that a point is learned twice with the same result, and with finite values."""
    from rl_design_space.learning import simulate  # imports Numba

    try:
        one, again = (simulate(point, threads=1, keep=["q"]) for _ in range(2))
    except ConfigError as error:
        raise AssertionError(str(error)) from error
    expect(np.array_equal(one.steps, again.steps), "it must learn the same at every call")
    finite = all(np.isfinite(period.q).all() for period in one.inside.values() if period.q is not None)
    expect(finite, "Q-values must stay finite")


def check_reward(reward: Reward) -> None:
    """Check that a reward function yields three finite rewards; and its potential or rewards by transition, if any."""
    check_value(reward, Reward)
    point = DesignPoint(reward=reward)
    repeatable("table()", partial(checked.rewards, point))
    for world, n_goals in product((*_WORLDS, Slip(size=3)), (1, 2, 3)):
        point = DesignPoint(reward=reward, world=world, task=Task(goals=n_goals))
        k = world.outcomes().cells.shape[-1] if isinstance(world, StochasticWorld) else 1
        if isinstance(reward, PotentialReward):
            check_layouts("potential()", partial(_table, checked.potential, point), cell_count(world), n_goals)
        if isinstance(reward, TransitionReward):
            found = partial(_table, partial(checked.by_transition, n_outcomes=k), point)
            check_layouts("by_transition()", found, cell_count(world), n_goals)


def _table(table: Callable[[DesignPoint, IntArray], FloatArray | None], point: DesignPoint, goals: IntArray) -> Any:
    return table(point, goals)


def check_msa(msa: ActionSet, representations: Sequence[Representation] = _SIGHTED) -> None:
    """Check the limits of a set of actions, and that what they do follows from the observation alone.

    Args:
        msa: the actions. A set of multi-step actions has the primitive actions first, then every other length once.
        representations: with which to check what they do; those that do not show what the actions need are left out.
    """
    check_value(msa, ActionSet)
    fitting = [
        point
        for representation in representations
        for world in _WORLDS
        for n_goals in (1, 2, 3)
        if (point := _fitting(msa, representation, world, n_goals))
    ]
    expect(bool(fitting), f"{type(msa).__name__} must fit a representation: no one shows what its actions need")
    repeatable("limits()", partial(checked.limits, fitting[0]))
    for point in fitting:
        cells, n_goals = cell_count(point.world), point.task.goals
        done = check_layouts("behaviour()", partial(_done, point), cells, n_goals)
        codes = checked.observation_codes(point, layouts(cells, n_goals))
        _, first, number = np.unique(codes, return_index=True, return_inverse=True)
        by_state = done.reshape(codes.size, -1)
        expect(
            np.array_equal(by_state, by_state[first][number.ravel()]),
            f"behaviour() must be the same at equal observations, but with {point.representation} it is not: actions "
            "may depend only on what the observation shows",
        )


def _fitting(msa: ActionSet, representation: Representation, world: World, n_goals: int) -> DesignPoint | None:
    """Return a point of these choices; None if the representation does not show what the actions need."""
    try:
        return DesignPoint(msa=msa, representation=representation, world=world, task=Task(goals=n_goals))
    except ValidationError:
        return None


def _done(point: DesignPoint, goals: IntArray) -> NDArray[np.int64]:
    """Return what the actions do in some layouts, (..., n_goals, cells, 2 · n_actions + 1)."""
    steps, stops, marks = checked.behaviour_of(point, goals, checked.observation_codes(point, goals))
    marks = np.zeros(steps.shape[1:], dtype=np.int64) if marks is None else marks
    return np.moveaxis(np.concatenate([steps, stops, marks[np.newaxis]]), 0, -1)


def check_curriculum(curriculum: Curriculum) -> None:
    """Check that a curriculum lists stages, the same at every call, through which a point can go."""
    check_value(curriculum, Curriculum)
    stages = curriculum.stage_list()
    expect(
        isinstance(stages, tuple) and all(isinstance(stage, Stage) for stage in stages),
        f"stage_list() must be a tuple of stages: {stages}",
    )
    expect(curriculum.stage_list() == stages, "stage_list() must return the same stages at every call")
    problems = []
    for representation in (AdHoc(), Aggregated()):
        try:
            DesignPoint(curriculum=curriculum, representation=representation, task=Task(goals=2))
        except ValueError as error:
            problems.append(str(error))
    expect(len(problems) < 2, problems[0] if problems else "")


def check_carry(rule: CarryRule, worlds: Sequence[World] = _WORLDS) -> None:
    """Check the ancestors that a carry rule gives, from each of these worlds to each."""
    for before, after in product(worlds, repeat=2):
        scenes = [_scene(before, [[0, 1], [2, 3]]), _scene(after, [[3, 1], [0, 2]])]
        found = repeatable(f"{function_name(rule)}()", partial(checked.ancestors, rule, *scenes))
        one_by_one = [checked.ancestors(rule, *(each.period(number) for each in scenes))[0] for number in range(2)]
        expect(np.array_equal(found, one_by_one), "ancestors of many periods must equal those of one at a time")


def check_study(name: str, config_dir: str | Path | None = None) -> None:
    """Check that a study can be planned, that every value of its points is allowed, and that its report can be built.

    Args:
        name: name of its file in `study/`, without `.yaml`.
        config_dir: config folder of your own that holds the file.
    """
    from rl_design_space.config.compose import shipped_config
    from rl_design_space.config.user_config import used
    from rl_design_space.plan.study import load_study

    try:
        with used(config_dir), shipped_config():
            study = load_study(name, ())
            if "report" in study.config.study:
                study.report()
    except ConfigError as error:
        raise AssertionError(str(error)) from error


def _scene(world: World, goals: list[list[int]]) -> StageScene:
    """Return a scene of several periods."""
    cells = np.array(goals, dtype=np.int32)
    return StageScene(world, cells, checked.portable_codes(DesignPoint(world=world, task=Task(goals=2)), cells))


def _offset(world: World, axis: int, goals: IntArray) -> IntArray:
    """Return the offsets along one axis, which must be whole numbers, one for each goal and cell."""
    way, shape = world.offset(goals)[axis], (*goals.shape, cell_count(world))
    right = isinstance(way, np.ndarray) and way.shape == shape and np.issubdtype(way.dtype, np.integer)
    expect(right, f"offset() must be two arrays of whole numbers of shape {shape}, along x and y")
    return way
