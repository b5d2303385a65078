"""The config files that Hydra finds: the shipped ones, and those in folders of the user."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import Any, cast

from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra.core.default_element import ConfigDefault, GroupDefault
from hydra.core.global_hydra import GlobalHydra
from hydra.core.object_type import ObjectType
from hydra.plugins.config_source import ConfigResult, ConfigSource
from omegaconf import OmegaConf

from rl_design_space._paths import make_plugins_known
from rl_design_space.config import user_config
from rl_design_space.config.compose import CONFIG_NAME, shipped_config
from rl_design_space.config.explain import unknown_option
from rl_design_space.config.overrides import OPTION_GROUPS
from rl_design_space.config.yaml_files import comments_of
from rl_design_space.errors import ConfigError

#: Groups beside the design choices, in the order in which they are listed.
_OTHER_GROUPS = ("tracking", "study")
#: Groups of Hydra to which this package adds options.
HYDRA_GROUPS = ("hydra/launcher", "hydra/sweeper")


class Search:
    """Access to the config files that Hydra finds; Hydra has to be initialized.

    Args:
        searchpath: `hydra.searchpath=…` overrides, which add places to search.
    """

    def __init__(self, searchpath: Sequence[str] = ()) -> None:
        self.searchpath = tuple(searchpath)
        loader = cast(ConfigLoaderImpl, GlobalHydra.instance().config_loader())
        self._repository = loader._parse_overrides_and_create_caching_repo(CONFIG_NAME, list(searchpath))[1]

    @cached_property
    def groups(self) -> tuple[str, ...]:
        """The config groups that have options: design choices, tracking, studies, then groups of the user."""
        there = self._repository.get_group_options("", ObjectType.GROUP)
        first = [group for group in (*OPTION_GROUPS, *_OTHER_GROUPS) if group in there]
        own = sorted(group for group in there if group not in first and group != "hydra" and self.options(group))
        return (*first, *own)

    def options(self, group: str) -> list[str]:
        """Return the options of a group, in alphabetical order."""
        return sorted(self._repository.get_group_options(group, ObjectType.CONFIG))

    def check(self, group: str, option: str) -> None:
        """Check that an option exists.

        Raises:
            ConfigError: the choice or the option does not exist; names the nearest one that does.
        """
        if group not in (*self.groups, *HYDRA_GROUPS):
            raise ConfigError.unknown("choice", group, (*self.groups, *HYDRA_GROUPS))
        if option not in self.options(group):
            raise unknown_option(group, option, self.options(group))

    @cached_property
    def defaults(self) -> dict[str, str | None]:
        """The default option of each group."""
        found: dict[str, str | None] = {}
        for default in self._load(CONFIG_NAME).defaults_list or ():
            if isinstance(default, GroupDefault):
                found[str(default.group)] = cast("str | None", default.value)
            elif not default.is_self():  # `hydra_defaults`
                listed = self._load(str(cast(ConfigDefault, default).path)).defaults_list or ()
                found |= {str(inner.group): str(inner.value) for inner in listed if isinstance(inner, GroupDefault)}
        return found

    def node(self, path: str) -> Any:
        """Return the content of a single config file, before composition.

        Args:
            path: group and option, e.g. `world/torus`.
        """
        return OmegaConf.to_container(self._load(path).config)

    def text(self, path: str) -> str:
        """Return the text of a config file, for its comments; empty if it cannot be read, or if it is no file."""
        source = self._source(path)
        if source.scheme() == "file":
            return comments_of(Path(source.path, f"{path}.yaml"))
        if source.scheme() == "pkg":
            package = files(source.path.replace("/", "."))
            return package.joinpath(f"{path}.yaml").read_text(encoding="utf-8")
        return ""

    def place(self, path: str) -> str:
        """Return the path of a config file, or the source of a config that does not come from a file."""
        source = self._source(path)
        if source.scheme() == "file":
            return str(Path(source.path, f"{path}.yaml"))
        return f"{source.scheme()}://{source.path or source.provider}"

    def _load(self, path: str) -> ConfigResult:
        found = self._repository.load_config(path)
        assert found is not None
        return found

    def _source(self, path: str) -> ConfigSource:
        return next(source for source in self._repository.get_sources() if source.is_config(path))


@contextmanager
def searched(config_dir: str | None = None, searchpath: Sequence[str] = ()) -> Iterator[Search]:
    """Initialize Hydra with the user's config folder and the shipped configuration.

    Args:
        config_dir: value of `--config-dir`; if None, the folder in use, if any.
        searchpath: `hydra.searchpath=…` overrides.

    Raises:
        ConfigError: the folder does not exist.
    """
    make_plugins_known()
    with user_config.used(config_dir), shipped_config():
        yield Search(searchpath)
