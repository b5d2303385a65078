"""Who records, and with which code."""

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
    """Tags for the runs that a command records; MLflow's client alone does not fill these in."""
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
        question = ["git", "-C", str(checkout), "rev-parse", "HEAD"]
        asked = subprocess.run(question, capture_output=True, text=True, check=False)
        if asked.returncode == 0:
            tags["mlflow.source.git.commit"] = asked.stdout.strip()
    return tags
