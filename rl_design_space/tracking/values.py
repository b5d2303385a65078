"""Values and names that MLflow stores unchanged; others are converted, or rejected by name."""

from __future__ import annotations

import hashlib
import math
import posixpath
import re
from typing import Any

from rl_design_space.errors import ConfigError

#: Maximum numbers of characters of a param, a tag, and any name (MLflow 3.17; a server refuses more).
PARAM_LENGTH, TAG_LENGTH, KEY_LENGTH = 6000, 5000, 250
#: Maximum number of characters of the name of a run; a server and SQLite take longer ones, PostgreSQL does not.
RUN_NAME_LENGTH = 250
_KEY = re.compile(r"[\w.\- :/]+")


def metric(value: Any) -> float | None:
    """Return a number as a float; None if it is not finite, which MLflow would store as another number.

    Raises:
        ConfigError: the value is not a number.
    """
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise ConfigError(f"a metric should be a number, not {value!r}") from error
    return number if math.isfinite(number) else None


def param(value: Any) -> str:
    """Return the text of a param; a text that is too long is cut and ends in its digest, so that it stays distinct."""
    return _shortened(_plain(value), PARAM_LENGTH)


def tag(value: Any) -> str:
    """Return the text of a tag; a text that is too long is cut and ends in its digest, so that it stays distinct."""
    return _shortened(_plain(value), TAG_LENGTH)


def run_name(name: str) -> str:
    """Return the name of a run; one that is too long is cut and ends in its digest, so that it stays distinct."""
    return _shortened(name, RUN_NAME_LENGTH)


def key(name: str) -> str:
    """Return the name of a metric, param or tag, unchanged.

    Raises:
        ConfigError: MLflow would refuse it.
    """
    if not _KEY.fullmatch(name):
        raise ConfigError(f"{name}: a name in MLflow may contain letters, digits, spaces and _ - . / : only")
    if len(name) > KEY_LENGTH:
        raise ConfigError(f"{name[:40]}…: a name in MLflow has at most {KEY_LENGTH} characters, not {len(name)}")
    if posixpath.normpath(name) != name or name == "." or name.startswith(("..", "/")):
        raise ConfigError(f"{name}: a name in MLflow should be a normal relative path, without empty parts, . and ..")
    return name


def _plain(value: Any) -> str:
    """Return a value as on the command line, NumPy numbers as Python numbers."""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_plain, value))}]"
    return str(value.item() if hasattr(value, "item") else value)


def _shortened(text: str, length: int) -> str:
    if len(text) <= length:
        return text
    end = f"… sha256:{hashlib.sha256(text.encode()).hexdigest()[:16]}"
    return text[: length - len(end)] + end
