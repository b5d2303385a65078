"""The config files that Hydra finds: the shipped ones, and those of a user's own folders."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import Any, cast

from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra.core.default_element import GroupDefault
from hydra.core.global_hydra import GlobalHydra
from hydra.core.object_type import ObjectType
from hydra.plugins.config_source import ConfigResult, ConfigSource
from omegaconf import OmegaConf

from rl_design_space._paths import make_plugins_known
from rl_design_space.config import user_config
from rl_design_space.config.compose import CONFIG_NAME, OPTION_GROUPS, shipped_config
from rl_design_space.config.explain import unknown_option
from rl_design_space.errors import ConfigError

#: Groups that say how points are run and which ones, in the order in which people meet them.
_OTHER_GROUPS = ("tracking", "study")
#: Hydra's groups that have options of ours.
HYDRA_GROUPS = ("hydra/launcher", "hydra/sweeper")


class Search:
    """Looks for options where Hydra, which has to be looking at a configuration, would look.

    Args:
        searchpath: `hydra.searchpath=…` overrides, which name more places.
    """

    def __init__(self, searchpath: Sequence[str] = ()) -> None:
        self.searchpath = tuple(searchpath)
        loader = cast(ConfigLoaderImpl, GlobalHydra.instance().config_loader())
        self._repository = loader._parse_overrides_and_create_caching_repo(CONFIG_NAME, list(searchpath))[1]

    @cached_property
    def groups(self) -> tuple[str, ...]:
        """The config groups that have options: design choices first, then tracking, studies, and any of a user's."""
        there = self._repository.get_group_options("", ObjectType.GROUP)
        first = [group for group in (*OPTION_GROUPS, *_OTHER_GROUPS) if group in there]
        own = sorted(group for group in there if group not in first and group != "hydra" and self.options(group))
        return (*first, *own)

    def options(self, group: str) -> list[str]:
        """The options of a group, in alphabetical order."""
        return sorted(self._repository.get_group_options(group, ObjectType.CONFIG))

    def check(self, group: str, option: str) -> None:
        """Make sure that there is such an option.

        Raises:
            ConfigError: there is none, with the nearest one that there is.
        """
        if group not in (*self.groups, *HYDRA_GROUPS):
            raise ConfigError.unknown("choice", group, (*self.groups, *HYDRA_GROUPS))
        if option not in self.options(group):
            raise unknown_option(group, option, self.options(group))

    @cached_property
    def defaults(self) -> dict[str, str | None]:
        """The option of each group that is taken unless another one is named."""
        listed = self._load(CONFIG_NAME).defaults_list or ()
        groups = [default for default in listed if isinstance(default, GroupDefault)]
        return {str(default.group): cast("str | None", default.value) for default in groups}

    def node(self, path: str) -> Any:
        """What a config file says, not composed with any other.

        Args:
            path: such as `world/torus`.
        """
        return OmegaConf.to_container(self._load(path).config)

    def text(self, path: str) -> str:
        """A config file as it was written; empty if the config is no file."""
        source = self._source(path)
        if source.scheme() == "file":
            return Path(source.path, f"{path}.yaml").read_text(encoding="utf-8")
        if source.scheme() == "pkg":
            package = files(source.path.replace("/", "."))
            return package.joinpath(f"{path}.yaml").read_text(encoding="utf-8")
        return ""

    def place(self, path: str) -> str:
        """Where a config file lies, for people."""
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
    """Have Hydra look at a folder of the user's own, and at the shipped configuration.

    Args:
        config_dir: the folder, as `--config-dir` names it; if None, the one that is in use, if any.
        searchpath: `hydra.searchpath=…` overrides.

    Raises:
        ConfigError: there is no such folder.
    """
    make_plugins_known()
    with user_config.used(config_dir), shipped_config():
        yield Search(searchpath)
