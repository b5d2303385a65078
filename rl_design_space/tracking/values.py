"""Values and keys as MLflow stores them well; what it would store badly is converted, or refused by name."""

from __future__ import annotations

import hashlib
import math
import posixpath
import re
from typing import Any

from rl_design_space.errors import ConfigError

#: Characters that a param, a tag, and any key may have (MLflow 3.17; a server refuses more).
PARAM_LENGTH, TAG_LENGTH, KEY_LENGTH = 6000, 5000, 250
_KEY = re.compile(r"[\w.\- :/]+")


def metric(value: Any) -> float | None:
    """A number as Python has it; None if it is not finite, which MLflow would store as another number.

    Raises:
        ConfigError: it is no number.
    """
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise ConfigError(f"a metric should be a number, not {value!r}") from error
    return number if math.isfinite(number) else None


def param(value: Any) -> str:
    """A param's text; one that is too long ends in its digest, so that different values stay different."""
    return _shortened(_plain(value), PARAM_LENGTH)


def tag(value: Any) -> str:
    """A tag's text; one that is too long ends in its digest."""
    return _shortened(_plain(value), TAG_LENGTH)


def key(name: str) -> str:
    """The name of a metric, param or tag, unchanged.

    Raises:
        ConfigError: MLflow would refuse it.
    """
    if not _KEY.fullmatch(name):
        raise ConfigError(f"{name}: MLflow takes names of letters, digits and _ - . / : and spaces only")
    if len(name) > KEY_LENGTH:
        raise ConfigError(f"{name[:40]}…: a name in MLflow has at most {KEY_LENGTH} characters, not {len(name)}")
    if posixpath.normpath(name) != name or name == "." or name.startswith(("..", "/")):
        raise ConfigError(f"{name}: MLflow takes names for paths, so that /, . and .. should stand between other parts")
    return name


def _plain(value: Any) -> str:
    """As on the command line: numbers of NumPy as those of Python."""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_plain, value))}]"
    return str(value.item() if hasattr(value, "item") else value)


def _shortened(text: str, length: int) -> str:
    if len(text) <= length:
        return text
    end = f"… sha256:{hashlib.sha256(text.encode()).hexdigest()[:16]}"
    return text[: length - len(end)] + end
