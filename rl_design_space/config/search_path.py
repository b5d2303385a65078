"""Hydra's search path: the user's config folder first, then the shipped one."""

from __future__ import annotations

from hydra._internal.sources_registry import SourcesRegistry
from hydra.core.config_search_path import ConfigSearchPath
from hydra.core.plugins import Plugins
from hydra.plugins.search_path_plugin import SearchPathPlugin

from rl_design_space._paths import CONF
from rl_design_space.config.user_config import user_folder
from rl_design_space.config.yaml_files import YamlFiles


class UserConfigFirst(SearchPathPlugin):
    """Puts the user's config folder before the shipped one; Hydra's `--config-dir` would put it after."""

    def manipulate_search_path(self, search_path: ConfigSearchPath) -> None:
        folder = user_folder()
        ours = any(element.path == str(CONF) for element in search_path.get_path())
        if folder is not None and ours:
            search_path.prepend("user", f"file://{folder}")


def look_in_user_folder_first() -> None:
    """Register the plugin, which lies outside the folders that Hydra searches for plugins, and the reader of files."""
    Plugins.instance().register(UserConfigFirst)
    SourcesRegistry.instance().types[YamlFiles.scheme()] = YamlFiles
