"""The YAML files of a configuration, read for Hydra: in UTF-8, and without the surprises of YAML 1.1."""

from __future__ import annotations

import re
from io import StringIO
from pathlib import Path

import yaml
from hydra._internal.core_plugins import file_config_source
from hydra.plugins.config_source import ConfigResult, ConfigSource
from omegaconf import OmegaConf

from rl_design_space.errors import ConfigError

#: Number of characters in which Hydra looks for `# @package`.
_HEADER = 512
#: Numbers that YAML 1.1 reads in base 8 or base 60, as whole scalars, and anything in a file that may be one.
_OCTAL, _SEXAGESIMAL = re.compile(r"[-+]?0[0-7_]+"), re.compile(r"[-+]?[0-9][0-9_]*(:[0-5]?[0-9])+(\.[0-9_]*)?")
_MAYBE = re.compile(r"(?<![\w.])0[0-7_]+(?![\w.])|\d:[0-5]?\d")


class FileConfigSource(file_config_source.FileConfigSource):
    """Hydra's source of config files in folders, with errors that name the file; it has to have the name of Hydra's.

    A byte-order mark is skipped; Hydra would not see the `# @package` behind it.
    """

    def load_config(self, config_path: str) -> ConfigResult:
        """Return a config file and its header.

        Raises:
            ConfigError: the file cannot be read, or holds a number that YAML 1.1 reads as another one.
        """
        path = Path(self.path, self._normalize_file_name(config_path)).resolve()
        if not path.exists():
            return super().load_config(config_path)  # which raises the error that Hydra expects
        text = _text(path)
        if _MAYBE.search(text):
            _refuse_old_numbers(path, text)
        stream = StringIO(text)
        stream.name = str(path)
        config = OmegaConf.load(stream)
        header = ConfigSource._get_header_dict(text[:_HEADER])
        return ConfigResult(self.provider, f"{self.scheme()}://{self.path}", config, header)


def comments_of(path: Path) -> str:
    """Return the text of a file for its comments; empty if it cannot be read."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError):
        return ""


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        byte = error.object[error.start]
        raise ConfigError(
            f"{path}:{line}: should be UTF-8, but holds the byte 0x{byte:02x}; save it as UTF-8"
        ) from error
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error


def _refuse_old_numbers(path: Path, text: str) -> None:
    """Refuse numbers that YAML 1.1 reads in base 8 or 60, unlike YAML 1.2 and people.

    Raises:
        ConfigError: the file holds one.
    """
    for event in yaml.parse(text, yaml.SafeLoader):
        if not isinstance(event, yaml.ScalarEvent) or not event.implicit[0]:
            continue
        base = 8 if _OCTAL.fullmatch(event.value) else 60 if _SEXAGESIMAL.fullmatch(event.value) else None
        if base:
            mark, value = event.start_mark, yaml.safe_load(event.value)
            place = f"{path}:{mark.line + 1}:{mark.column + 1}" if mark else path
            raise ConfigError(
                f"{place}: {event.value} is {value} in YAML, a number in base {base}; "
                f'write {value}, or "{event.value}" if it is text'
            )
