"""Studies: named unions of grids of design points."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from omegaconf import DictConfig

from rl_design_space.errors import ConfigError
from rl_design_space.sweep.build import build, is_setting, plain
from rl_design_space.sweep.compose import Composer
from rl_design_space.sweep.grid import as_overrides, expand
from rl_design_space.sweep.plan import PlannedPoint


@dataclass(frozen=True)
class Study:
    """A study as one call asks for it.

    Attributes:
        name: of its file in conf/study.
        overrides: of the command line, beside the name.
        config: composed, with the settings.
        plan: its design points, equal ones once.
    """

    name: str
    overrides: tuple[str, ...]
    config: DictConfig
    plan: list[PlannedPoint]

    @property
    def command(self) -> str:
        """The command that runs it."""
        return shlex.join(["rl-design-space", f"study={self.name}", *self.overrides])

    @property
    def report_command(self) -> str:
        """The command that writes its report."""
        return shlex.join(["rl-design-report", self.name, *self.overrides])

    def report(self) -> Any:
        """The report that the study's file describes.

        Raises:
            ConfigError: it describes none, or not properly.
        """
        node = plain(self.config, "study").get("report")
        if node is None:
            raise ConfigError(f"study {self.name}: its file describes no report")
        return build("study.report", node)


def load_study(name: str, overrides: Sequence[str]) -> Study:
    """Compose and plan a study.

    Args:
        name: of the study.
        overrides: of the command line; they replace what a block says of the same key.

    Raises:
        ConfigError: there is no such study, a sweep is not understood or a value is not allowed.
    """
    composer = Composer()
    overrides = tuple(override for override in overrides if not override.startswith("study="))
    config = composer.config([f"study={name}", *filter(is_setting, overrides)])
    return Study(name, overrides, config, plan_study(name, config, overrides, composer))


def plan_study(name: str, config: DictConfig, overrides: Sequence[str], composer: Composer) -> list[PlannedPoint]:
    """All points of a study, in the order of its blocks; equal points once.

    Args:
        name: of the study.
        config: composed config whose `study.blocks` hold the sweeps of each block, by key; all combinations of a
            block are points.
        overrides: as above.
        composer: makes points of overrides.

    Raises:
        ConfigError: as above, or there is no point at all.
    """
    blocks = plain(config, "study").get("blocks")
    if not isinstance(blocks, Mapping) or not all(isinstance(sweeps, Mapping) for sweeps in blocks.values()):
        raise ConfigError(f"study {name}: needs blocks, each a mapping of keys to sweeps")
    planned: dict[str, PlannedPoint] = {}
    for block, sweeps in blocks.items():
        try:
            of_points = [override for override in overrides if not override.startswith("study.")]
            grid = expand([*as_overrides(sweeps), *of_points], composer.parser)
            points = [composer(values, studies=(name,)) for values in grid]
        except ConfigError as error:
            raise ConfigError(f"study {name}, block {block}: {error}") from error
        for point in points:
            planned.setdefault(point.fingerprint, point)
    if not planned:
        raise ConfigError(f"study {name}: no design point in it; its blocks are {', '.join(blocks) or 'none'}")
    return list(planned.values())
