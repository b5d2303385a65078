"""Studies: named unions of grids of design points."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.errors import HydraException
from omegaconf import DictConfig

from rl_design_space.errors import ConfigError
from rl_design_space.sweep.build import SETTINGS, build, plain
from rl_design_space.sweep.compose import Composer, check_options
from rl_design_space.sweep.explain import explain
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
    config = composer.config([f"study={name}", *filter(_is_setting, overrides)])
    return Study(name, overrides, config, plan_study(name, config, overrides, composer))


def split_arguments(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Split a command line into what Hydra is to compose and, if it names a study, what the study's points take over.

    Flags, settings and everything that is not an override go to Hydra.
    """
    if not any(argument.startswith("study=") for argument in arguments):
        return list(arguments), []
    for_points = [argument for argument in arguments if _is_override(argument) and not _is_setting(argument)]
    return [argument for argument in arguments if argument not in for_points], for_points


def check_arguments(arguments: Sequence[str]) -> None:
    """Check the overrides of a command line as far as that is possible before Hydra composes them.

    Raises:
        ConfigError: one is not an override, or gives a value where an option is needed.
    """
    try:
        check_options(OverridesParser.create().parse_overrides([a for a in arguments if _is_override(a)]))
    except HydraException as error:
        raise explain(error) or error from error


def _is_override(argument: str) -> bool:
    """Whether an argument is an override, rather than a flag or a flag's value."""
    return "=" in argument and re.match(r"[+~]*[A-Za-z_]", argument) is not None


def _is_setting(override: str) -> bool:
    """Whether an override concerns how points are run, not the points."""
    return re.match(rf"[+~]*({'|'.join(SETTINGS)})(?=[./@=]|$)", override) is not None


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
            grid = expand([*_as_overrides(sweeps), *of_points], composer.parser)
            points = [composer(values, studies=(name,)) for values in grid]
        except ConfigError as error:
            raise ConfigError(f"study {name}, block {block}: {error}") from error
        for point in points:
            planned.setdefault(point.fingerprint, point)
    if not planned:
        raise ConfigError(f"study {name}: no design point in it; its blocks are {', '.join(blocks) or 'none'}")
    return list(planned.values())


def expand(overrides: Sequence[str], parser: OverridesParser) -> list[tuple[str, ...]]:
    """All combinations of the values that sweep overrides list; the last override of a key counts.

    Raises:
        ConfigError: an override cannot be parsed or enumerated.
    """
    try:
        axes: dict[str, list[str]] = {}
        for override in parser.parse_overrides(list(overrides)):
            key = override.get_key_element()
            if not override.is_sweep_override():
                values = [override.get_value_element_as_str()]
            elif override.is_discrete_sweep():
                values = list(override.sweep_string_iterator())
            else:
                raise ConfigError(f"{override.input_line}: an interval has no list of values; use choice or range")
            if not values:
                raise ConfigError(f"{override.input_line}: matches nothing")
            axes.pop(override.key_or_group, None)  # +key and ~key take the place of key
            axes[key] = [f"{key}={value}" for value in values]
    except Exception as error:
        if explained := explain(error):
            raise explained from error
        raise
    return list(product(*axes.values()))


def _as_overrides(sweeps: Mapping[str, Any]) -> list[str]:
    """A block as one would type it; strings are Hydra's sweep grammar, anything else is a value."""
    return [f"{key}={_typed(value)}" for key, value in sweeps.items()]


def _typed(value: Any) -> str:
    """A value in Hydra's grammar."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, Mapping):
        return f"{{{','.join(f'{key}:{_typed(item)}' for key, item in value.items())}}}"
    if isinstance(value, list):
        return f"[{','.join(map(_typed, value))}]"
    return str(value)
