"""Compose command-line overrides into the parts of a design point."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import deepcopy
from functools import cache, cached_property
from typing import Any, cast

import hydra
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError

from rl_design_space._paths import CONF
from rl_design_space.config.agreement import Agreement, comparable, is_separable
from rl_design_space.config.assemble import Assembler, Parts, file_reaches_out
from rl_design_space.config.build import build_values
from rl_design_space.config.explain import explain, explained
from rl_design_space.config.grammar import parse
from rl_design_space.config.overrides import (
    ABSENT,
    ABSENT_OPTION,
    OPTION_GROUPS,
    is_of_study,
    is_search_path,
    is_setting,
    is_sweep_setting,
)
from rl_design_space.config.resolvers import register_resolvers
from rl_design_space.config.search_path import look_in_user_folder_first
from rl_design_space.config.stage_options import CURRICULUM, check_stages
from rl_design_space.config.study_file import with_study
from rl_design_space.errors import ConfigError

CONFIG_NAME = "config"
register_resolvers()


@contextmanager
def shipped_config() -> Iterator[None]:
    """Initialize Hydra with the user's and the shipped configuration, and restore its state afterwards."""
    look_in_user_folder_first()
    outer = GlobalHydra.instance().hydra
    GlobalHydra.instance().clear()
    try:
        with hydra.initialize_config_dir(str(CONF), job_name="rl-design-space", version_base="1.3"):
            yield
    finally:
        GlobalHydra.instance().hydra = outer


class Composer:
    """Composes the parts of many points from the configuration that Hydra has initialized.

    A composition by Hydra takes 150 ms. Most points need none: they are assembled from options that are read once each
    (see `Assembler`). Other points with the same options differ only in values, so each combination of options is
    composed once and the values are set in a copy.

    Args:
        always: overrides of every composition, e.g. `hydra.searchpath=…`, which adds places to look for options.
        name: name of the primary config.
        sweep: composed config of the sweep that the points belong to; its settings apply to all of them.
    """

    def __init__(self, always: Sequence[str] = (), name: str = CONFIG_NAME, sweep: DictConfig | None = None) -> None:
        self._always = list(always)
        self._name = name
        self._loader = cast(ConfigLoaderImpl, GlobalHydra.instance().config_loader())
        self._repository = self._loader._parse_overrides_and_create_caching_repo(name, self._always)[1]
        self._bases: dict[tuple[str, ...], DictConfig] = {}
        self._is_setting = cache(is_setting)
        self._agreement = Agreement(sweep)
        #: By settings: whether points with these and no others agree with the sweep.
        self._agreed: dict[tuple[str, ...], bool] = {}
        self.parser = OverridesParser.create(config_loader=self._loader)

    @classmethod
    def like(cls, config: DictConfig) -> Composer:
        """Return a composer for the points of a sweep with this composed config."""
        typed: Any = OmegaConf.to_container(config.hydra.overrides)  # with interpolations as they are
        of_sweep = filter(is_sweep_setting, typed["task"])
        always = [*typed["hydra"], *(text for text in of_sweep if not is_of_study(text))]
        return cls(always, config.hydra.job.config_name, config)

    def parts(self, overrides: Sequence[str]) -> Parts:
        """Return the validated parts of the point that these overrides describe.

        Whether the parts are compatible with each other is not checked.

        Raises:
            ConfigError: an override cannot be parsed, its value is not allowed, or a setting differs from that of the
                sweep.
        """
        settings = tuple(filter(self._is_setting, overrides))
        if settings not in self._agreed:
            self._agreed[settings] = self._agree(settings)
        try:
            assembled = self._assembler(overrides) if self._agreed[settings] else None
            return assembled or self._composed(overrides)
        except YAMLError as error:  # in an option's file
            raise explain(error) or error from error

    def options(self, group: str) -> list[str]:
        """Return the names of the options of a config group."""
        return list(self._loader.get_group_options(group))

    def _agree(self, settings: Sequence[str]) -> bool:
        """Return whether the settings of points with these are those of the sweep, whatever the points are."""
        try:
            config = self.config(settings)
            return is_separable(config) and self._agreement.holds(config)
        except ConfigError:  # unless a file that a point chooses has the key
            return False

    def _composed(self, overrides: Sequence[str]) -> Parts:
        config = self.config(overrides)
        self._agreement.check(config, overrides)
        return parts_of(config)

    def of_points(self, overrides: Sequence[str]) -> list[str]:
        """Return the overrides without those that only change how a sweep is run.

        One that chooses a file is kept if the file changes points as well.
        """
        return [text for text in overrides if not is_sweep_setting(text) or self._changes_points(text)]

    def _changes_points(self, text: str) -> bool:
        places = list(filter(is_search_path, self._always))
        with explained():
            override = self.parser.parse_override(text)
            if not file_reaches_out(self._repository, f"{override.key_or_group}/{override.value()}"):
                return False
            composed = [hydra.compose(self._name, [*places, *more], return_hydra_config=True) for more in ([text], [])]
        with_it, without_it = [comparable(config, "study" if is_of_study(text) else "hydra") for config in composed]
        return with_it != without_it

    @cached_property
    def _assembler(self) -> Assembler:
        defaults = self.config(())
        return Assembler(self._repository, self._name, defaults, OPTION_GROUPS, self.parser)

    def config(self, overrides: Sequence[str]) -> DictConfig:
        """Return the composed config, including the `hydra` node.

        Raises:
            ConfigError: an override cannot be parsed, or its value is not allowed.
        """
        with explained():
            parsed = parse(overrides, self.parser)
            if any(self._changes_keys(override) for override in parsed):
                return self._compose(overrides)
            options = tuple(o.input_line or "" for o in parsed if not self._sets_a_value(o))
            config = self._with_study(options) or deepcopy(self._base(options))
            for override in filter(self._sets_a_value, parsed):
                _set(config, override)
        return config

    def _base(self, options: tuple[str, ...]) -> DictConfig:
        if options not in self._bases:
            self._bases[options] = self._compose(options)
        return self._bases[options]

    def _with_study(self, options: Sequence[str]) -> DictConfig | None:
        """Return the config with one option, a study; None if Hydra has to compose it."""
        if len(options) != 1 or not is_of_study(options[0]):
            return None
        return with_study(self.config(()), options[0], self.parser, self._repository)

    def _compose(self, overrides: Sequence[str]) -> DictConfig:
        always = [override for override in self._always if override not in overrides]
        return hydra.compose(self._name, [*always, *overrides], return_hydra_config=True)

    def _changes_keys(self, override: Override) -> bool:
        """Return whether an override adds or deletes a key, so that the order of the overrides matters."""
        return override.is_add() or override.is_force_add() or override.is_delete()

    def _sets_a_value(self, override: Override) -> bool:
        """Return whether an override only replaces a value and does not change which files are composed."""
        return (
            override.package is None
            and not self._repository.group_exists(override.key_or_group)
            and not override.is_hydra_override()
            and not override.is_sweep_override()
        )


def _set(config: DictConfig, override: Override) -> None:
    try:
        OmegaConf.update(config, override.key_or_group, override.value(), merge=True)
    except ValueError as error:
        if isinstance(error, OmegaConfBaseException):
            raise
        raise ConfigError.at(override.key_or_group, override.value(), f"no such key: {error}") from error


def parts_of(config: DictConfig, choices: Mapping[str, str | None] | None = None) -> Parts:
    """Return the parts of the point that a composed config describes.

    Args:
        config: the composed config.
        choices: name of the chosen option by config group; if None, those in the `hydra` node of the config.

    Raises:
        ConfigError: a value is not allowed.
    """
    choices = config.hydra.runtime.choices if choices is None else choices
    choices = {group: choices.get(group) or (ABSENT_OPTION if group in ABSENT else None) for group in OPTION_GROUPS}
    for group in OPTION_GROUPS:
        if not choices[group]:
            raise ConfigError(f"{group}: name exactly one option, as in {group}=OPTION")
    values = build_values(config)
    check_stages(str(choices[CURRICULUM]), values[CURRICULUM])
    return Parts(values, {group: str(choices[group]) for group in OPTION_GROUPS})
