"""Checks of user components when points are planned, so that a broken one does not fail thousands of points."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from itertools import pairwise
from types import FunctionType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rl_design_space.design import ClosedLoop, DesignPoint, OwnLearner, possible_cells, stages_of
from rl_design_space.design.identity import full_name, function_name, is_shipped
from rl_design_space.design.ways import missing_way
from rl_design_space.errors import ConfigError
from rl_design_space.learning import checked
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.learning.stage_layouts import StageScene, stage_layouts

#: Arrays that components return, by choice, class and method.
_Tables = Mapping[str, NDArray[Any]]


class ComponentCheck:
    """Calls each user component for every combination of components and sizes that it depends on.

    The returned arrays must have the shape, type and range of their contract, and an equal component, built from the
    same fields, must return equal ones: results are found by the fields of a component, so it must not draw random
    numbers. Updates of learners and rules of closed loops are compiled. Other exceptions of a component are ignored
    here: the point that raises them fails when it is learned, and the others go on.
    """

    def __init__(self) -> None:
        self._checked: set[tuple[Any, ...]] = set()

    def __call__(self, point: DesignPoint) -> None:
        """Check the user components of a point that were not checked yet.

        Raises:
            ConfigError: a component breaks its contract, or some goals of a world cannot be reached.
        """
        stages = stages_of(point)
        for stage in stages:
            self(stage.point)
            if isinstance(stage.carry, FunctionType):
                self._run(_ancestors, point, (stage.carry,), *stages)
        task, world = point.task, point.world
        self._run(_world, point, (world,), task.goals)
        self._run(_schedule, point, (point.exploration,), task.trials)
        self._run(_rewards, point, (point.reward, world), task.goals)
        self._run(_limits, point, (point.msa,))
        self._run(_actions, point, (point.msa, point.representation, world), task.goals)
        self._run(_codes, point, (point.representation, world), task.goals)
        self._run(_update, point, (point.learner,))
        self._run(_rule, point, (point.exploration,))

    def _run(
        self, tables: Callable[[DesignPoint], _Tables], point: DesignPoint, components: tuple[Any, ...], *more: Any
    ) -> None:
        own = [type(component) for component in components if not is_shipped(type(component))]
        if not own or not self._is_new(own, (tables, *components, *more)):
            return
        try:
            found = {method: table.copy() for method, table in tables(point).items()}
            again = tables(_twin(point))
        except ConfigError:
            raise
        except Exception:
            return
        for method, table in found.items():
            if not np.array_equal(table, again[method]):
                raise ConfigError(
                    f"{method} gives other values at a second call; results are found by the fields of a component, so "
                    "it must not draw random numbers, except from a generator that a field seeds"
                )

    def _is_new(self, own: list[type], check: tuple[Any, ...]) -> bool:
        try:
            known = check in self._checked
            self._checked.add(check)
        except TypeError as error:
            names = " or ".join(full_name(kind) for kind in own)
            raise ConfigError(f"{names}: should be a frozen dataclass of hashable values; {error}") from error
        return not known


def _twin(point: DesignPoint) -> DesignPoint:
    """Return an equal point whose user components were built a second time from the values of their fields."""
    choices = {field.name: getattr(point, field.name) for field in fields(point)}
    return replace(point, **{name: _rebuilt(value) for name, value in choices.items() if not is_shipped(type(value))})


def _rebuilt(component: Any) -> Any:
    """Return a component built again, or the component itself where that gives another one.

    The latter is not an error here: `__post_init__` may compute a field from itself.
    """
    try:
        twin = replace(component)
        return twin if twin == component else component
    except Exception:
        return component


def _world(point: DesignPoint) -> _Tables:
    next_cell, cells, outcomes = checked.transitions(point), checked.places(point), checked.outcomes(point)
    name = full_name(type(point.world))
    method = "next_cell" if outcomes is None else "outcomes"
    if missing := missing_way(next_cell if outcomes is None else possible_cells(outcomes), cells):
        width = point.world.shape[0]
        origin, goal = (f"(x={cell % width}, y={cell // width})" for cell in missing)
        raise ConfigError(
            f"world: {name}.{method}() leaves no way from {origin} to {goal}, so a goal there "
            "could not be reached; leave such cells out of open_cells(), or open a way"
        )
    drawn = {} if outcomes is None else {f"world: {name}.outcomes()": np.concatenate(outcomes, axis=-1)}
    return {f"world: {name}.next_cell()": next_cell, f"world: {name}.open_cells()": cells, **drawn}


def _schedule(point: DesignPoint) -> _Tables:
    return {f"exploration: {full_name(type(point.exploration))}.schedule()": checked.epsilons(point)}


def _rewards(point: DesignPoint) -> _Tables:
    name, goals = full_name(type(point.reward)), layouts_of(point, periods=2)[:, 1:]
    outcomes = checked.outcomes(point)
    k = 1 if outcomes is None else outcomes.cells.shape[-1]
    height, more = checked.potential(point, goals), checked.by_transition(point, goals, k)
    return {
        f"reward: {name}.table()": checked.rewards(point),
        **({} if height is None else {f"reward: {name}.potential()": height}),
        **({} if more is None else {f"reward: {name}.by_transition()": more}),
    }


def _limits(point: DesignPoint) -> _Tables:
    return {f"msa: {full_name(type(point.msa))}.limits()": checked.limits(point)}


def _actions(point: DesignPoint) -> _Tables:
    if point.msa.repeats:
        return {}
    goals = layouts_of(point, periods=2)[:, 1:]
    table = checked.action_table(point, goals, checked.observation_codes(point, goals))
    name = f"msa: {full_name(type(point.msa))}.behaviour()"
    return {} if table is None else {f"{name}.steps": table.controls, f"{name}.marks": table.marks}


def _codes(point: DesignPoint) -> _Tables:
    codes = checked.observation_codes(point, layouts_of(point, periods=2)[:, 1:])
    names = f"{full_name(type(point.representation))}.observation() in {full_name(type(point.world))}"
    return {f"representation: {names}": codes}


def _update(point: DesignPoint) -> _Tables:
    """Compile the update of a learner; to call it takes a period."""
    if isinstance(point.learner, OwnLearner):
        from rl_design_space.learning.sequential.own import compiled_update  # late: it imports Numba

        compiled_update(type(point.learner).update, full_name(type(point.learner)))
    return {}


def _rule(point: DesignPoint) -> _Tables:
    """Compile the rule of a closed loop."""
    if isinstance(point.exploration, ClosedLoop):
        from rl_design_space.learning.sequential.own import compiled_rule

        compiled_rule(type(point.exploration).rule, full_name(type(point.exploration)))
    return {}


def _ancestors(point: DesignPoint) -> _Tables:
    stages = stages_of(point)
    scenes = [
        StageScene(stage.point.world, layout[:, 1:], checked.portable_codes(stage.point, layout[:, 1:]))
        for stage, layout in zip(stages, stage_layouts(point, stages, periods=2), strict=True)
    ]
    return {
        f"carry: {function_name(stage.carry)}()": checked.ancestors(stage.carry, before, after)
        for stage, (before, after) in zip(stages[1:], pairwise(scenes), strict=True)
        if isinstance(stage.carry, FunctionType)
    }
