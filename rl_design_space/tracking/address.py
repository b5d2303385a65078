"""The address of an MLflow tracking store."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from rl_design_space._paths import expanded
from rl_design_space._secrets import has_secret

SQLITE = "sqlite:///"
#: Characters of a path that have a meaning of their own in a database URL.
_SPECIAL = re.compile(r"[?%]")
_CONTROL = re.compile(r"[\x00-\x1f\x7f]")


@dataclass(frozen=True)
class StoreAddress:
    """A tracking store and the experiments in it that results are recorded in.

    Attributes:
        uri: URI of the tracking store.
        experiment: name of the experiment that holds the design points.
        sweeps: name of the experiment that holds a summary run for each sweep.
    """

    uri: str
    experiment: str
    sweeps: str

    @property
    def is_server(self) -> bool:
        """Whether the store is a tracking server, not a database."""
        return is_server(self.uri)


def is_server(uri: str) -> bool:
    """Return whether a URI is that of a tracking server."""
    return uri.startswith(("http:", "https:", "databricks"))


def checked_uri(uri: str) -> str:
    """Return a URI, with the home folder in place of `~`, if it may be that of a tracking store.

    Raises:
        ValueError: it is none, or holds a password or token, which would be recorded.
    """
    if has_secret(uri):
        raise ValueError("should not hold a password or token; see docs/server.md for where it belongs")
    if not re.match(r"[a-z][a-z0-9+]*:", uri) or not uri.partition(":")[2].strip("/"):
        raise ValueError("should be a tracking URI such as sqlite:///FILE, postgresql://… or http://…")
    if uri.startswith("http") and not re.match("https?://[^/]", uri):
        raise ValueError("should name a host, as in http://HOST:5000")
    if _CONTROL.search(uri) or (sqlite_path(uri) is None and re.search(r"\s", uri)):
        raise ValueError("should not hold spaces or control characters")
    return f"{SQLITE}{expanded(uri.removeprefix(SQLITE))}" if uri.startswith(SQLITE) else uri


def sqlite_path(uri: str) -> Path | None:
    """Return the absolute path of the database file that a SQLite URI names; None for any other URI.

    The path is taken literally: `%20` and `?` are characters of names.
    """
    return Path(uri.removeprefix(SQLITE)).absolute() if uri.startswith(SQLITE) else None


def absolute(uri: str) -> str:
    """Return a URI that names the same store from any working directory."""
    path = sqlite_path(uri)
    return f"{SQLITE}{path}" if path else uri


def mlflow_uri(uri: str) -> str:
    """Return a URI by which MLflow and SQLAlchemy find a store, in which `?` and `%` have a meaning.

    MLflow also creates the folder that such a URI names when it is taken literally. So everything from the first of
    these characters on is encoded, slashes too: that folder then exists.
    """
    path = sqlite_path(uri)
    special = _SPECIAL.search(str(path)) if path else None
    if path is None or special is None:
        return uri
    return f"{SQLITE}{str(path)[: special.start()]}{quote(str(path)[special.start() :], safe='')}"
