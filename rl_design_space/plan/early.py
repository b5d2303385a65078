"""Components of the user's own are tried when points are planned, before thousands of points fail of one of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rl_design_space.design import DesignPoint
from rl_design_space.design.identity import full_name, is_shipped
from rl_design_space.errors import ConfigError
from rl_design_space.learning import checked
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.learning.ways import missing_way


class EarlyCheck:
    """Tries each of the user's own components once, with what it is used with.

    What they yield has to have the shape, type and range of their contract. An exception that one of them raises is
    left to the point that it concerns: it fails alone when it is learned.
    """

    def __init__(self) -> None:
        self._tried: set[tuple[Any, ...]] = set()

    def __call__(self, point: DesignPoint) -> None:
        """Try what is own of a point and was not tried yet.

        Raises:
            ConfigError: a component does not keep its contract, or the goals of a world cannot all be reached.
        """
        task, world = point.task, point.world
        self._try(_world, point, (world,), task.goals)
        self._try(checked.epsilons, point, (point.exploration,), task.trials)
        self._try(checked.rewards, point, (point.reward,))
        self._try(checked.lengths, point, (point.msa,))
        self._try(_codes, point, (point.representation, world), task.goals)

    def _try(
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

    def _is_new(self, own: list[type], tried: tuple[Any, ...]) -> bool:
        try:
            known = tried in self._tried
            self._tried.add(tried)
        except TypeError as error:
            names = " or ".join(full_name(kind) for kind in own)
            raise ConfigError(f"{names}: should be a frozen dataclass of values that can be hashed; {error}") from error
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
