"""The address of an MLflow tracking store."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

SQLITE = "sqlite:///"


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


def sqlite_path(uri: str) -> Path | None:
    """Return the absolute path of the database file that a SQLite URI names; None for any other URI."""
    return Path(uri.removeprefix(SQLITE)).absolute() if uri.startswith(SQLITE) else None


def absolute(uri: str) -> str:
    """Return a URI that names the same store from any working directory."""
    path = sqlite_path(uri)
    return f"{SQLITE}{path}" if path else uri
