"""Checks of user components when points are planned, so that a broken one does not fail thousands of points."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rl_design_space.design import DesignPoint
from rl_design_space.design.identity import full_name, is_shipped
from rl_design_space.errors import ConfigError
from rl_design_space.learning import checked
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.learning.ways import missing_way


class ComponentCheck:
    """Calls each user component once per combination of components and sizes that it depends on.

    The returned arrays must have the shape, type and range of their contract. Other exceptions of a component are
    ignored here: the point that raises them fails when it is learned, and the others go on.
    """

    def __init__(self) -> None:
        self._checked: set[tuple[Any, ...]] = set()

    def __call__(self, point: DesignPoint) -> None:
        """Check the user components of a point that were not checked yet.

        Raises:
            ConfigError: a component breaks its contract, or some goals of a world cannot be reached.
        """
        task, world = point.task, point.world
        self._run(_world, point, (world,), task.goals)
        self._run(checked.epsilons, point, (point.exploration,), task.trials)
        self._run(checked.rewards, point, (point.reward,))
        self._run(checked.lengths, point, (point.msa,))
        self._run(_codes, point, (point.representation, world), task.goals)

    def _run(
        self, check: Callable[[DesignPoint], Any], point: DesignPoint, components: tuple[Any, ...], *more: int
    ) -> None:
        own = [type(component) for component in components if not is_shipped(type(component))]
        if not own or not self._is_new(own, (check, *components, *more)):
            return
        try:
            check(point)
        except ConfigError:
            raise
        except Exception:
            return

    def _is_new(self, own: list[type], check: tuple[Any, ...]) -> bool:
        try:
            known = check in self._checked
            self._checked.add(check)
        except TypeError as error:
            names = " or ".join(full_name(kind) for kind in own)
            raise ConfigError(f"{names}: should be a frozen dataclass of hashable values; {error}") from error
        return not known


def _world(point: DesignPoint) -> None:
    next_cell, cells = checked.transitions(point), checked.places(point)
    if missing := missing_way(next_cell, cells):
        width = point.world.shape[0]
        origin, goal = (f"(x={cell % width}, y={cell // width})" for cell in missing)
        raise ConfigError(
            f"world: {full_name(type(point.world))}.next_cell() leaves no way from {origin} to {goal}, so a goal there "
            "could not be reached; leave such cells out of open_cells(), or open a way"
        )


def _codes(point: DesignPoint) -> None:
    checked.observation_codes(point, layouts_of(point, periods=2)[:, 1:])
