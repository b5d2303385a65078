"""Labels: how names of parameters, their values and measures read in reports, from a file of the user's own."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import yaml

from rl_design_space.config import user_config
from rl_design_space.errors import ConfigError

#: The file in the user's config folder whose labels every report uses.
FILE_NAME = "labels.yaml"
_EXPECTED = "should be a mapping of names to texts, such as exploration.k: decay, or representation=ad_hoc: ad hoc"


def own_labels() -> dict[str, str]:
    """Return the labels of the user's config folder; none if it has no such file.

    Raises:
        ConfigError: the file cannot be read, or is no mapping of names to texts.
    """
    folder = user_config.user_folder()
    return labels_of(folder / FILE_NAME) if folder and (folder / FILE_NAME).is_file() else {}


def labels_of(path: Path) -> dict[str, str]:
    """Return the labels of a file.

    Raises:
        ConfigError: the file cannot be read, or is no mapping of names to texts.
    """
    try:
        node = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror})") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: is not valid YAML; {_EXPECTED}") from error
    return checked(node, str(path))


def checked(node: object, place: str = "labels") -> dict[str, str]:
    """Return labels as text by name.

    Args:
        node: a mapping of names to texts; numbers count as they are written.
        place: where they come from, for messages.

    Raises:
        ConfigError: it is no such mapping.
    """
    if not isinstance(node, Mapping):
        raise ConfigError.at(place, node, _EXPECTED)
    for name, text in node.items():
        if isinstance(text, bool) or not isinstance(text, str | int | float):
            raise ConfigError.at(f"{place}.{name}", text, "should be a text")
        if not str(text).strip():
            raise ConfigError.at(f"{place}.{name}", text, "should not be empty; left out, the name stands as it is")
    return {str(name): str(text) for name, text in node.items()}
