"""The error that a user can fix; the command line shows it as one message, without a traceback, and exits with 2."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches

from rl_design_space._yaml import as_yaml

#: A password in a URI, and what comes before it. A port is none; databases take passwords with slashes.
_PASSWORD = re.compile(r"(://[^/\s:@]*:)(?!\d*/)\S+(?=@)|([?&]password=)[^&\s]+")


class ConfigError(ValueError):
    """Something in a configuration, on the command line or in a file, cannot be used as it is."""

    @classmethod
    def at(cls, key: str, value: object, expected: str) -> ConfigError:
        """Return the usual form: key, value, and what would be right."""
        return cls(f"{key}={without_passwords(as_yaml(value))}: {expected}")

    @classmethod
    def unknown(cls, what: str, name: str, known: Iterable[str], prefix: str = "") -> ConfigError:
        """Return the error about a name that does not exist, with the nearest one that does."""
        known = sorted(known)
        beginning = [candidate for candidate in known if name and candidate.startswith(name)]
        nearest = beginning or get_close_matches(name, known, n=1, cutoff=0.5)
        hint = f"; did you mean {prefix}{nearest[0]}?" if nearest else ""
        return cls(f"{prefix}{name}: no such {what}{hint} (there is {', '.join(known) or 'none'})")


def has_password(text: str) -> bool:
    """Return whether a text holds a URI with a password."""
    return _PASSWORD.search(text) is not None


def without_passwords(text: str) -> str:
    """Return the text without the passwords of its URIs."""
    return _PASSWORD.sub(r"\1\2…", text)
