"""The YAML files of a configuration, read for Hydra: within the limits on YAML, see `yaml_limits`."""

from __future__ import annotations

from pathlib import Path

from hydra._internal.core_plugins.file_config_source import FileConfigSource
from hydra.plugins.config_source import ConfigResult
from omegaconf.errors import OmegaConfBaseException

from rl_design_space.config import user_config
from rl_design_space.config.yaml_limits import check_limits, read_text
from rl_design_space.errors import ConfigError


class YamlFiles(FileConfigSource):
    """Hydra's source of config files in folders, none of which is too large."""

    def load_config(self, config_path: str) -> ConfigResult:
        """Return a config file and its header.

        Raises:
            ConfigError: the file is too large, or holds a value that cannot be read.
        """
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


# Hydra knows its source of files by this name, and registers it again in the processes of its launchers.
YamlFiles.__name__ = FileConfigSource.__name__
