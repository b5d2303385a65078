"""How Hydra reads config files: within the limits on YAML, see `yaml_limits`."""

from __future__ import annotations

from pathlib import Path

from hydra._internal.core_plugins import file_config_source
from hydra._internal.sources_registry import SourcesRegistry
from hydra.core.plugins import Plugins
from hydra.plugins.config_source import ConfigResult
from omegaconf.errors import OmegaConfBaseException

from rl_design_space.config import user_config
from rl_design_space.config.yaml_limits import check_limits, read_text
from rl_design_space.errors import ConfigError


class FileConfigSource(file_config_source.FileConfigSource):  # the name by which Hydra recognises its source of files
    """A folder of config files, none of which is too large."""

    def load_config(self, config_path: str) -> ConfigResult:
        path = Path(self.path, self._normalize_file_name(config_path))
        if path.is_file():
            check_limits(read_text(path), user_config.shown(path))
        try:
            return super().load_config(config_path)
        except ValueError as error:
            if isinstance(error, (ConfigError, OmegaConfBaseException)):
                raise
            # A number of thousands of digits, or an impossible date.
            raise ConfigError(f"{user_config.shown(path)}: cannot be read: {str(error).partition(';')[0]}") from error


def limit_config_files() -> None:
    """Let Hydra read config files within the limits."""
    Plugins.instance()  # registers Hydra's own source if it has not yet
    SourcesRegistry.instance().types[FileConfigSource.scheme()] = FileConfigSource
