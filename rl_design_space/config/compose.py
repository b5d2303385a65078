"""From command-line overrides to the parts of a design point."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import fields
from functools import cache, cached_property
from typing import cast

import hydra
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra.core.global_hydra import GlobalHydra
from hydra.core.object_type import ObjectType
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override, ValueType
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError

from rl_design_space._paths import CONF
from rl_design_space.config.assemble import Assembler, Parts
from rl_design_space.config.build import build_values
from rl_design_space.config.explain import explain
from rl_design_space.config.overrides import is_setting
from rl_design_space.config.search_path import look_in_user_folder_first
from rl_design_space.design import DesignPoint
from rl_design_space.errors import ConfigError

CONFIG_NAME = "config"
#: The design choices that are config groups: all but plain numbers.
OPTION_GROUPS = tuple(field.name for field in fields(DesignPoint) if field.name not in ("seed", "task"))


@contextmanager
def shipped_config() -> Iterator[None]:
    """Make Hydra find the user's and the shipped configuration, whatever it was looking at before."""
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

    Hydra's own composition takes 150 ms. Most points need none: options are read once each and put together (see
    `Assembler`). Of the others, those that choose the same options differ in values only, so each combination of
    options is composed once and the values are put into a copy.

    Args:
        searchpath: `hydra.searchpath=…` overrides, which say where to look for options as well.
    """

    def __init__(self, searchpath: Sequence[str] = ()) -> None:
        self._searchpath = list(searchpath)
        self._loader = cast(ConfigLoaderImpl, GlobalHydra.instance().config_loader())
        self._repository = self._loader._parse_overrides_and_create_caching_repo(CONFIG_NAME, self._searchpath)[1]
        self._groups = set(self._repository.get_group_options("", ObjectType.GROUP))
        self._bases: dict[tuple[str, ...], DictConfig] = {}
        self._is_setting = cache(is_setting)
        self._valid_settings: set[tuple[str, ...]] = {()}
        self.parser = OverridesParser.create(config_loader=self._loader)

    def parts(self, overrides: Sequence[str]) -> Parts:
        """The parts of the point that these overrides describe, each valid; whether they go together is not checked.

        Raises:
            ConfigError: an override is not understood or its value is not allowed.
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
        """The composed config, Hydra's own part included.

        Raises:
            ConfigError: as above.
        """
        try:
            parsed = self.parser.parse_overrides(list(overrides))
            check_options(parsed)
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
        return hydra.compose(CONFIG_NAME, [*self._searchpath, *overrides], return_hydra_config=True)

    def _changes_keys(self, override: Override) -> bool:
        """Whether an override adds or deletes a key; its place among the others then counts."""
        return override.is_add() or override.is_force_add() or override.is_delete()

    def _sets_a_value(self, override: Override) -> bool:
        """Whether an override only replaces a value, and leaves alone which files are composed."""
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
        raise ConfigError.at(override.key_or_group, override.value(), f"there is no such key: {error}") from error


def check_options(overrides: Sequence[Override]) -> None:
    """Refuse values where an option's name is needed, which Hydra would answer without saying where.

    Raises:
        ConfigError: such as `world=10`.
    """
    for override in overrides:
        key = override.key_or_group
        if not (key in (*OPTION_GROUPS, "tracking", "study") or key.startswith("hydra/")):
            continue
        named: tuple[type, ...] = (str, list, dict)
        if override.is_delete() or (key == "study" and not override.is_add()):
            named = (*named, type(None))  # `~world` has no value, and `study=null` is none
        if override.value_type == ValueType.ELEMENT and not isinstance(override.value(), named):
            sign = "~" if override.is_delete() else ""
            raise ConfigError.at(f"{sign}{key}", override.value(), "name exactly one option")


def parts_of(config: DictConfig, choices: Mapping[str, str | None] | None = None) -> Parts:
    """The parts of a composed config.

    Args:
        config: the composed config.
        choices: name of the option chosen in every config group, unless Hydra's part of the config tells.

    Raises:
        ConfigError: a value is not allowed.
    """
    choices = config.hydra.runtime.choices if choices is None else choices
    for group in OPTION_GROUPS:
        if not choices.get(group):
            raise ConfigError(f"{group}: name exactly one option, as in {group}=OPTION")
    return Parts(build_values(config), {group: str(choices[group]) for group in OPTION_GROUPS})
