"""The error that a user can fix; the command line shows it as one message, without a traceback, and exits with 2."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches

#: A password in a URI, and what comes before it. A port is none; databases take passwords with slashes.
_PASSWORD = re.compile(r"(://[^/\s:@]*:)(?!\d*/)\S+(?=@)|([?&]password=)[^&\s]+")


class ConfigError(ValueError):
    """Something in a configuration, on the command line or in a file, cannot be used as it is."""

    @classmethod
    def at(cls, key: str, value: object, expected: str) -> ConfigError:
        """The usual form: which key, which value, and what would be right."""
        return cls(f"{key}={_as_typed(value)}: {expected}")

    @classmethod
    def unknown(cls, what: str, name: str, known: Iterable[str], prefix: str = "") -> ConfigError:
        """A name that does not exist, with the nearest one that does."""
        known = sorted(known)
        beginning = [candidate for candidate in known if name and candidate.startswith(name)]
        nearest = beginning or get_close_matches(name, known, n=1, cutoff=0.5)
        hint = f"; did you mean {prefix}{nearest[0]}?" if nearest else ""
        return cls(f"{prefix}{name}: no such {what}{hint} (there is {', '.join(known) or 'none'})")


def _as_typed(value: object) -> str:
    """A value as one would type it in YAML."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_as_typed, value))}]"
    return without_passwords(str(value))


def has_password(text: str) -> bool:
    """Whether a text holds a URI with a password."""
    return _PASSWORD.search(text) is not None


def without_passwords(text: str) -> str:
    """The same text, with what is secret in its URIs left out."""
    return _PASSWORD.sub(r"\1\2…", text)
