"""Where Hydra looks for config files: in the user's folder first, then in the shipped one."""

from __future__ import annotations

from hydra.core.config_search_path import ConfigSearchPath
from hydra.core.plugins import Plugins
from hydra.plugins.search_path_plugin import SearchPathPlugin

from rl_design_space._paths import CONF
from rl_design_space.config.user_config import user_folder


class UserConfigFirst(SearchPathPlugin):
    """Puts the user's config folder before the shipped one; Hydra's own `--config-dir` would put it behind."""

    def manipulate_search_path(self, search_path: ConfigSearchPath) -> None:
        folder = user_folder()
        ours = any(element.path == str(CONF) for element in search_path.get_path())
        if folder is not None and ours:
            search_path.prepend("user", f"file://{folder}")


def look_in_user_folder_first() -> None:
    """Have Hydra ask the plugin; it would find it by itself only in a folder that it knows."""
    Plugins.instance().register(UserConfigFirst)
