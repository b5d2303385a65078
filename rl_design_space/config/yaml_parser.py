"""The parser of YAML files: that of OmegaConf, of which libyaml does the work for the shipped files.

libyaml takes an eighth of the time, in every command that composes a config. It accepts some texts that PyYAML refuses,
and its errors read differently: so PyYAML alone parses files of users, and shipped ones that libyaml refuses.
"""

from __future__ import annotations

from functools import cache
from io import StringIO
from pathlib import Path
from typing import Any

import yaml
from omegaconf._utils import get_yaml_loader

from rl_design_space._paths import CONF


def parse_yaml(text: str, path: Path) -> Any:
    """Return the plain values of a YAML text.

    Args:
        text: the YAML.
        path: of its file, which errors name.

    Raises:
        YAMLError: the text is not YAML, or repeats a key.
    """
    quick = _quick_loader() if _is_shipped(path) else None
    if quick is not None:
        try:
            return yaml.load(text, quick)
        except (yaml.YAMLError, ValueError):  # the message is PyYAML's
            pass
    stream = StringIO(text)
    stream.name = str(path)
    return yaml.load(stream, get_yaml_loader())


def parse_events(text: str, path: Path) -> list[yaml.Event]:
    """Return the events of a YAML text, as `parse_yaml` would meet them.

    Raises:
        YAMLError: the text is not YAML.
    """
    if yaml.__with_libyaml__ and _is_shipped(path):
        try:
            return list(yaml.parse(text, yaml.CSafeLoader))
        except yaml.YAMLError:  # the message is PyYAML's
            pass
    return list(yaml.parse(text, yaml.SafeLoader))


def _is_shipped(path: Path) -> bool:
    return CONF in path.parents


@cache
def _quick_loader() -> Any:
    """Return OmegaConf's loader on top of libyaml; None if PyYAML was built without it."""
    if not yaml.__with_libyaml__:
        return None
    # OmegaConf's rules for keys and numbers on top of libyaml's parser.
    return type("QuickLoader", (yaml.CSafeLoader, get_yaml_loader()), {})
