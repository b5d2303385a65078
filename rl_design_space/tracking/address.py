"""Where results are recorded: the address of an MLflow tracking store."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

SQLITE = "sqlite:///"


@dataclass(frozen=True)
class StoreAddress:
    """Where results are recorded.

    Attributes:
        uri: of the tracking store.
        experiment: name of the experiment that holds the design points.
        sweeps: name of the experiment that holds a summary run for each sweep.
    """

    uri: str
    experiment: str
    sweeps: str

    @property
    def is_server(self) -> bool:
        """Whether it is a tracking server, not a database."""
        return is_server(self.uri)


def is_server(uri: str) -> bool:
    """Whether a URI is that of a tracking server."""
    return uri.startswith(("http:", "https:", "databricks"))


def sqlite_path(uri: str) -> Path | None:
    """The database file that a SQLite URI names, absolute; None for any other store."""
    return Path(uri.removeprefix(SQLITE)).absolute() if uri.startswith(SQLITE) else None


def absolute(uri: str) -> str:
    """The same store, from whatever folder."""
    path = sqlite_path(uri)
    return f"{SQLITE}{path}" if path else uri
