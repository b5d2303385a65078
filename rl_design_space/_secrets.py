"""Secrets in addresses: passwords and tokens in URIs, however they are written.

One parser for all that is typed, printed and recorded. It reads an address as the libraries do that connect to it: in
urllib and requests the part before the host ends at the first slash, in SQLAlchemy a password may hold slashes. Where
they differ, the text counts as a secret.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple
from urllib.parse import unquote

#: The beginning of a URI with a host, also with too few slashes; `sqlite:///` is followed by a path.
_BEGINNING = re.compile(r"(?P<web>https?)?(?(web)|[a-z][a-z0-9+.\-]{0,30}(?=:/)):/{0,2}(?!/)", re.IGNORECASE)
_HOST_AND_PORT = re.compile(r"(\[[^\]]*\]|[^:]*)(:\d*)?")
_WORD = "(?:pass(?:word|wd|phrase)|pwd|secret|token|credential|signature|(?:api|access)_?key)s?"
#: A parameter of a URI; what a parameter holds once it is decoded, also one of a connection string inside of it.
_PARAMETER = re.compile(r"(?<=[?&;#])(?P<name>[^\s?&;#=]*)(?P<value>=?[^\s?&;#]*)")
_SECRET = re.compile(rf"(?:^|[?&;#{{\s])[\w.\-]*{_WORD}\s*=\s*[^\s&;#…]", re.IGNORECASE)
#: An override that sets a secret, such as an environment variable for jobs; one that refers to a variable does not.
_SETTING = re.compile(rf"(?<![^\s'\"])[+~]*(?:hydra|tracking)[\w./@]*{_WORD}=(?!\$\{{|null\b|…)(\S+)", re.IGNORECASE)
_HIDDEN = "…"
#: How often a text may be percent-encoded, and how many characters may stand before a host.
_ENCODINGS, _LONGEST = 3, 2_000


class _Part(NamedTuple):
    """A part of a text that holds a secret, and what is shown in its place."""

    start: int
    end: int
    shown: str


def has_secret(text: str) -> bool:
    """Return whether an argument or a URI holds a password or token, however it is written."""
    return any(without_secrets(text, is_address=is_address) != text for is_address in (False, True))


def without_secrets(text: str, *, is_address: bool = False) -> str:
    """Return a text without the passwords and tokens of the URIs and overrides in it, also if it is escaped for Hydra.

    Args:
        text: the text.
        is_address: whether the whole text is one URI; otherwise, a URI ends at a space.
    """
    for plain in (text, text.replace("\\", "")) if "\\" in text else (text,):
        if parts := sorted({*_before_hosts(plain, is_address), *_parameters(plain), *_settings(plain)}):
            return _replaced(plain, parts)
    return text


def _before_hosts(text: str, is_address: bool) -> Iterator[_Part]:
    """Yield the user and password of each URI, if they hold a secret."""
    for found in _BEGINNING.finditer(text):
        rest = text[found.end() : found.end() + _LONGEST]
        if not is_address:
            rest = re.split(r"\s", rest, maxsplit=1)[0]
        user = _before_host(rest, bool(found["web"]))
        name, _, password = _decoded(user).partition(":")
        if password or (found["web"] and name):
            # Servers take tokens as users, too.
            shown = f"{user.partition(':')[0]}:{_HIDDEN}" if ":" in user and not found["web"] else _HIDDEN
            yield _Part(found.end(), found.end() + len(user), shown)


def _before_host(rest: str, web: bool) -> str:
    """Return what stands before the host in a URI without its scheme; empty if nothing does.

    Args:
        rest: the URI without its scheme.
        web: whether it is that of a web server.
    """
    host = re.split(r"[/?#]", rest, maxsplit=1)[0]
    has_port = _HOST_AND_PORT.fullmatch(host) is not None
    # Databases take `user:1/2@host` for a user with a password; for a web server, the port and a path.
    if "@" in host or (":" in host and not (web and has_port)):
        return rest.rpartition("@")[0]
    return ""


def _parameters(text: str) -> Iterator[_Part]:
    """Yield the values of the parameters that hold a secret, of a URI or of a connection string."""
    for found in _PARAMETER.finditer(text):
        if _SECRET.search(_decoded(found[0])):
            name = found["name"] if _SECRET.search(f"{found['name']}=x") else ""
            yield _Part(found.start(), found.end(), f"{name}={_HIDDEN}" if name else _HIDDEN)


def _settings(text: str) -> Iterator[_Part]:
    """Yield the values of overrides that set a secret."""
    for found in _SETTING.finditer(text):
        yield _Part(*found.span(1), _HIDDEN)


def _decoded(text: str) -> str:
    for _ in range(_ENCODINGS if "%" in text else 0):
        text = unquote(text)
    return text


def _replaced(text: str, parts: list[_Part]) -> str:
    """Return a text with other texts in place of some parts, which may overlap."""
    shown, position = [], 0
    for part in parts:
        if part.start >= position:
            shown += [text[position : part.start], part.shown]
        position = max(position, part.end)
    return "".join([*shown, text[position:]])
