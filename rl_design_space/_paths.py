"""Where the shipped configuration and plugins lie; paths of the user: names that may be paths, writable folders."""

import os
import re
import sys
from pathlib import Path

_PACKAGE = Path(__file__).parent

#: `conf` inside the package when installed from a wheel, beside it in a checkout.
CONF = next((path for path in (_PACKAGE / "conf", _PACKAGE.parent / "conf") if path.is_dir()), _PACKAGE / "conf")

#: A folder that holds a part of the package `hydra_plugins`.
_PLUGINS = str(_PACKAGE / "_plugins")


def make_plugins_known() -> None:
    """Let Hydra find our plugins, in this process and in those that it starts; before Hydra looks for any."""
    if _PLUGINS not in sys.path:
        sys.path.append(_PLUGINS)
    inherited = [path for path in os.environ.get("PYTHONPATH", "").split(os.pathsep) if path]
    if _PLUGINS not in inherited:
        os.environ["PYTHONPATH"] = os.pathsep.join([*inherited, _PLUGINS])


def leads_out(name: str) -> bool:
    """Return whether a name that becomes a path in some folder leads out of that folder, or is no path at all."""
    return name.startswith("/") or ".." in name.split("/") or re.search(r"[\x00-\x1f\x7f]", name) is not None


def expanded(path: str) -> str:
    """Return a path with the home folder in place of `~`."""
    return str(Path(path).expanduser()) if path.startswith("~") else path


def why_unwritable(path: Path) -> str:
    """Return why a path, or a folder to be created at it, cannot be written to; empty if it can."""
    existing = next(each for each in (path.absolute(), *path.absolute().parents) if each.exists())
    if os.access(existing, os.W_OK):
        return ""
    return "read-only file system" if os.statvfs(existing).f_flag & os.ST_RDONLY else "permission denied"
