"""The YAML files of a configuration, read for Hydra: in UTF-8, within limits, and without the surprises of YAML 1.1."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from types import NoneType
from typing import Any

import yaml
from hydra._internal.core_plugins.file_config_source import FileConfigSource
from hydra.plugins.config_source import ConfigResult, ConfigSource
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException

from rl_design_space.config import user_config
from rl_design_space.config.yaml_limits import CHARACTERS, check_limits
from rl_design_space.config.yaml_parser import parse_events, parse_yaml
from rl_design_space.errors import ConfigError

#: Number of characters in which Hydra looks for `# @package`.
_HEADER = 512
#: Numbers that YAML 1.1 reads in base 8 or base 60, as whole scalars, and anything in a file that may be one.
_OCTAL, _SEXAGESIMAL = re.compile(r"[-+]?0[0-7_]+"), re.compile(r"[-+]?[0-9][0-9_]*(:[0-5]?[0-9])+(\.[0-9_]*)?")
_MAYBE = re.compile(r"(?<![\w.])0[0-7_]+(?![\w.])|\d:[0-5]?\d")


class YamlFiles(FileConfigSource):
    """Hydra's source of config files in folders, with errors that name the file.

    A byte-order mark is skipped; Hydra would not see the `# @package` behind it.
    """

    def load_config(self, config_path: str) -> ConfigResult:
        """Return a config file and its header.

        Raises:
            ConfigError: the file cannot be read, is too large, or holds a number that YAML 1.1 reads as another one.
        """
        path = Path(self.path, self._normalize_file_name(config_path))
        if not path.exists():
            return super().load_config(config_path)  # which raises the error that Hydra expects
        text = _text(path)
        config = OmegaConf.create(_values(text, path, user_config.shown(path)))
        header = ConfigSource._get_header_dict(text[:_HEADER])
        return ConfigResult(self.provider, f"{self.scheme()}://{self.path}", config, header)


# Hydra knows its source of files by this name, and registers it again in the processes of its launchers.
YamlFiles.__name__ = FileConfigSource.__name__


def comments_of(path: Path) -> str:
    """Return the text of a file for its comments; empty if it cannot be read."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError):
        return ""


@lru_cache(maxsize=256)
def _values(text: str, path: Path, shown: str) -> Any:
    """Return the plain values of a YAML text, as OmegaConf reads them; composing studies reads most files often.

    Raises:
        ConfigError: the text is too large, or holds a number that YAML 1.1 reads as another one, or that is none.
    """
    check_limits(text, shown)
    if _MAYBE.search(text):
        _refuse_old_numbers(shown, parse_events(text, path))
    try:
        values = parse_yaml(text, path)
    except ValueError as error:
        if isinstance(error, (ConfigError, OmegaConfBaseException)):
            raise
        # A number of thousands of digits, or an impossible date.
        raise ConfigError(f"{shown}: cannot be read: {str(error).partition(';')[0]}") from error
    if not isinstance(values, (dict, list, str, NoneType)):
        raise ConfigError(f"{shown}: should hold keys and values, not {values}")
    return {} if values is None else values


def _text(path: Path) -> str:
    """Return the text of a file, cut where it is too large."""
    try:
        with path.open(encoding="utf-8-sig") as file:
            return file.read(CHARACTERS + 1)
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        wrong = f"should be UTF-8, but holds the byte 0x{error.object[error.start]:02x}; save it as UTF-8"
        raise ConfigError(f"{user_config.shown(path)}:{line}: {wrong}") from error
    except OSError as error:
        raise ConfigError(f"{user_config.shown(path)}: cannot be read: {error.strerror}") from error


def _refuse_old_numbers(name: str, events: Iterable[yaml.Event]) -> None:
    """Refuse numbers that YAML 1.1 reads in base 8 or 60, unlike YAML 1.2 and people.

    Raises:
        ConfigError: the text holds one.
    """
    for event in events:
        if not isinstance(event, yaml.ScalarEvent) or not event.implicit[0]:
            continue
        base = 8 if _OCTAL.fullmatch(event.value) else 60 if _SEXAGESIMAL.fullmatch(event.value) else None
        if base:
            mark, value = event.start_mark, yaml.safe_load(event.value)
            place = f"{name}:{mark.line + 1}:{mark.column + 1}" if mark else name
            raise ConfigError(
                f"{place}: {event.value} is {value} in YAML, a number in base {base}; "
                f'write {value}, or "{event.value}" if it is text'
            )
