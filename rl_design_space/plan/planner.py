"""Plan points from overrides."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from omegaconf import DictConfig

from rl_design_space.config import user_config
from rl_design_space.config.assemble import Parts
from rl_design_space.config.build import make_point
from rl_design_space.config.compose import Composer, parts_of, shipped_config
from rl_design_space.design import DesignPoint
from rl_design_space.learning.precision import Precision
from rl_design_space.plan.component_check import ComponentCheck
from rl_design_space.plan.plan import PlannedPoint


class Planner:
    """Plans many points; user components are checked once, see `ComponentCheck`.

    Args:
        composer: composes the parts of points.
        progress: called for each combination of a sweep, with its number and the number of all combinations.
    """

    def __init__(
        self, composer: Composer | None = None, progress: Callable[[int, int], None] = lambda number, total: None
    ) -> None:
        self.composer = composer or Composer()
        self.progress = progress
        #: Studies that are included by others, by the overrides of the command and their names.
        self.included: dict[tuple[str, ...], dict[str, Any]] = {}
        self._check = ComponentCheck()

    def __call__(self, overrides: Sequence[str], studies: tuple[str, ...] = ()) -> PlannedPoint:
        """Plan the point that these overrides describe.

        Raises:
            ConfigError: an override is not understood or its value is not allowed.
        """
        return self.of_parts(self.composer.parts(overrides), overrides, studies)

    def of_parts(self, parts: Parts, overrides: Sequence[str], studies: tuple[str, ...] = ()) -> PlannedPoint:
        """Plan the point with these parts.

        Args:
            parts: of the point.
            overrides: that the parts were composed from.
            studies: names of the studies that the point belongs to.

        Raises:
            ConfigError: the parts contradict each other, or a user component breaks its contract.
        """
        return _planned(parts, overrides, studies, self._check)


def plan_composed(config: DictConfig, choices: Mapping[str, str | None], overrides: Sequence[str]) -> PlannedPoint:
    """Plan the point of a config that Hydra has composed.

    Args:
        config: the composed config.
        choices: name of the option chosen in every config group.
        overrides: that the config was composed from.

    Raises:
        ConfigError: a value is not allowed, or a user component breaks its contract.
    """
    return _planned(parts_of(config, choices), overrides, (), ComponentCheck())


def plan_point(overrides: Sequence[str] = ()) -> PlannedPoint:
    """Plan the point that these overrides of the user's and the shipped configuration describe.

    Raises:
        ConfigError: an override is not understood or its value is not allowed.
    """
    with shipped_config():
        return Planner()(overrides)


def point_from_overrides(overrides: Sequence[str] = (), config_dir: str | Path | None = None) -> DesignPoint:
    """Return the point that these command-line overrides describe, e.g. `["exploration=linear", "world.size=20"]`.

    Args:
        overrides: as on the command line.
        config_dir: folder with your own options; modules beside it can be imported from then on.

    Raises:
        ConfigError: an override is not understood or its value is not allowed.
    """
    with user_config.used(config_dir):
        return plan_point(overrides).point


def _planned(parts: Parts, overrides: Sequence[str], studies: tuple[str, ...], check: ComponentCheck) -> PlannedPoint:
    point = make_point(parts.values)
    if rule := Precision.of_task(point.task):
        rule.check()
    check(point)
    return PlannedPoint.of(point, parts.options, tuple(overrides), studies)
