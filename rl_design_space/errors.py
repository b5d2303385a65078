"""The error that a user can fix; the command line shows it as one message, without a traceback, and exits with 2."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from rl_design_space._secrets import without_secrets
from rl_design_space._yaml import as_yaml

#: Maximum number of characters of a message.
_LONGEST = 10_000


class ConfigError(ValueError):
    """Something in a configuration, on the command line or in a file, cannot be used as it is.

    Passwords and tokens in the message are left out, and very long messages are cut.

    Args:
        message: what is wrong, and what would be right.
    """

    def __init__(self, message: str) -> None:
        super().__init__(without_secrets(message if len(message) <= _LONGEST else f"{message[:_LONGEST]}…"))

    @classmethod
    def at(cls, key: str, value: object, expected: str) -> ConfigError:
        """Return the usual form: key, value, and what would be right."""
        return cls(f"{key}={without_secrets(as_yaml(value), is_address=isinstance(value, str))}: {expected}")

    @classmethod
    def unknown(cls, what: str, name: str, known: Iterable[str], prefix: str = "") -> ConfigError:
        """Return the error about a name that does not exist, with the nearest one that does."""
        known = sorted(known)
        beginning = [candidate for candidate in known if name and candidate.startswith(name)]
        nearest = beginning or get_close_matches(name, known, n=1, cutoff=0.5)
        hint = f"; did you mean {prefix}{nearest[0]}?" if nearest else ""
        return cls(f"{prefix}{name}: no such {what}{hint} (there is {', '.join(known) or 'none'})")
