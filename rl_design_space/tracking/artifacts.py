"""Where the files of runs are kept."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path
from urllib.parse import urlparse
from urllib.request import url2pathname

from rl_design_space.tracking.address import StoreAddress, sqlite_path

#: What a folder may be named without the help of a digest, after spaces have become hyphens.
_PLAIN = re.compile(r"[\w-][\w.-]*")


def artifacts_folder(address: StoreAddress, spools: Path) -> Path | None:
    """Return where the artifacts of a store go.

    Args:
        address: of the store.
        spools: folder of all spools.

    Returns:
        A folder beside a SQLite database. For any other database, one beside the spools: by default, MLflow would use a
        folder in the working directory. None for a server, which has its own place.
    """
    if address.is_server:
        return None
    return (sqlite_path(address.uri) or spools).parent / "artifacts"


def experiment_artifacts(folder: Path, name: str) -> str:
    """Return the URI of the folder for the artifacts of an experiment.

    Args:
        folder: of the artifacts of a store.
        name: of the experiment; whatever it contains, its folder lies in that of the store.
    """
    plain = name.replace(" ", "-")
    if not _PLAIN.fullmatch(plain):
        digest = hashlib.sha256(name.encode()).hexdigest()[:12]
        plain = re.sub(r"[^\w-]+", "-", plain)[:40] + f"-{digest}"
    return (folder / plain).as_uri()


def is_local(uri: str) -> bool:
    """Return whether the URI of a folder of artifacts names one of this machine."""
    parts = urlparse(uri)
    return parts.scheme in ("", "file") and parts.netloc in ("", "localhost")


def write_artifacts(uri: str, artifacts: Mapping[str, bytes]) -> None:
    """Write files into a folder of artifacts on this machine.

    Args:
        uri: of the folder.
        artifacts: contents of files by name.
    """
    parts = urlparse(uri)
    folder = Path(url2pathname(parts.path) if parts.scheme else uri)
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in artifacts.items():
        (folder / name).write_bytes(content)
