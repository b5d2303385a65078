"""Compose command-line overrides into the parts of a design point."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import deepcopy
from functools import cache, cached_property
from typing import cast

import hydra
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra.core.global_hydra import GlobalHydra
from hydra.core.object_type import ObjectType
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError

from rl_design_space._paths import CONF
from rl_design_space.config.assemble import Assembler, Parts
from rl_design_space.config.build import build_values
from rl_design_space.config.explain import explain
from rl_design_space.config.grammar import parse
from rl_design_space.config.overrides import OPTION_GROUPS, is_search_path, is_setting
from rl_design_space.config.search_path import look_in_user_folder_first
from rl_design_space.errors import ConfigError

CONFIG_NAME = "config"


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
        search_path: `hydra.searchpath=…` overrides, which add places to look for options.
    """

    def __init__(self, search_path: Sequence[str] = ()) -> None:
        self._search_path = list(search_path)
        self._loader = cast(ConfigLoaderImpl, GlobalHydra.instance().config_loader())
        self._repository = self._loader._parse_overrides_and_create_caching_repo(CONFIG_NAME, self._search_path)[1]
        self._groups = set(self._repository.get_group_options("", ObjectType.GROUP))
        self._bases: dict[tuple[str, ...], DictConfig] = {}
        self._is_setting = cache(is_setting)
        self._valid_settings: set[tuple[str, ...]] = {()}
        self.parser = OverridesParser.create(config_loader=self._loader)

    @classmethod
    def like(cls, config: DictConfig) -> Composer:
        """Return a composer with the search path of a composed config."""
        return cls(list(filter(is_search_path, config.hydra.overrides.hydra)))

    def parts(self, overrides: Sequence[str]) -> Parts:
        """Return the validated parts of the point that these overrides describe.

        Whether the parts are compatible with each other is not checked.

        Raises:
            ConfigError: an override cannot be parsed, or its value is not allowed.
        """
        settings = tuple(filter(self._is_setting, overrides))
        if settings not in self._valid_settings:
            self.config(settings)
            self._valid_settings.add(settings)
        try:
            return self._assembler(overrides) or parts_of(self.config(overrides))
        except YAMLError as error:  # in an option's file
            raise explain(error) or error from error

    @cached_property
    def _assembler(self) -> Assembler:
        defaults = self.config(())
        return Assembler(self._repository, CONFIG_NAME, defaults, OPTION_GROUPS, self.parser)

    def config(self, overrides: Sequence[str]) -> DictConfig:
        """Return the composed config, including the `hydra` node.

        Raises:
            ConfigError: an override cannot be parsed, or its value is not allowed.
        """
        try:
            parsed = parse(overrides, self.parser)
            if any(self._changes_keys(override) for override in parsed):
                return self._compose(overrides)
            options = tuple(o.input_line or "" for o in parsed if not self._sets_a_value(o))
            if options not in self._bases:
                self._bases[options] = self._compose(options)
            config = deepcopy(self._bases[options])
            for override in filter(self._sets_a_value, parsed):
                _set(config, override)
        except Exception as error:
            if explained := explain(error):
                raise explained from error
            raise
        return config

    def _compose(self, overrides: Sequence[str]) -> DictConfig:
        return hydra.compose(CONFIG_NAME, [*self._search_path, *overrides], return_hydra_config=True)

    def _changes_keys(self, override: Override) -> bool:
        """Return whether an override adds or deletes a key, so that the order of the overrides matters."""
        return override.is_add() or override.is_force_add() or override.is_delete()

    def _sets_a_value(self, override: Override) -> bool:
        """Return whether an override only replaces a value and does not change which files are composed."""
        return (
            override.package is None
            and override.key_or_group not in self._groups
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
    for group in OPTION_GROUPS:
        if not choices.get(group):
            raise ConfigError(f"{group}: name exactly one option, as in {group}=OPTION")
    return Parts(build_values(config), {group: str(choices[group]) for group in OPTION_GROUPS})
