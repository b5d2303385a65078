"""Tags that say who recorded a run, and with which code."""

from __future__ import annotations

import getpass
import platform
import shutil
import subprocess
from contextlib import suppress

from rl_design_space._paths import CONF
from rl_design_space._version import __version__
from rl_design_space.tracking import values


def origin_tags(command: str) -> dict[str, str]:
    """Return the tags of the runs that a command records; MLflow's client does not set them by itself."""
    tags = {
        "rl_design_space.version": __version__,
        "rl_design_space.host": platform.node(),
        "mlflow.source.name": values.tag(command),
        "mlflow.source.type": "LOCAL",
    }
    with suppress(OSError, KeyError):  # a user without a name
        tags["mlflow.user"] = getpass.getuser()
    checkout = CONF.parent
    if (checkout / ".git").exists() and shutil.which("git"):
        command_line = ["git", "-C", str(checkout), "rev-parse", "HEAD"]
        process = subprocess.run(command_line, capture_output=True, text=True, check=False)
        if process.returncode == 0:
            tags["mlflow.source.git.commit"] = process.stdout.strip()
    return tags
