"""The folders that commands write to."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from rl_design_space._paths import why_unwritable
from rl_design_space.errors import ConfigError

if TYPE_CHECKING:
    from rl_design_space.run.settings import Settings


def report_folder(settings: Settings) -> Path:
    """Return the folder of the reports, which need not exist yet.

    Raises:
        ConfigError: it cannot be written to.
    """
    from rl_design_space.tracking import MlflowTracking

    folder = Path(settings.outputs) / "report"
    if reason := why_unwritable(folder):
        store = (
            f" {shlex.quote(f'tracking.uri={settings.tracking.uri}')}"
            if isinstance(settings.tracking, MlflowTracking)
            else ""
        )
        raise ConfigError(f"{folder}: cannot be written to ({reason}); outputs=DIR{store} writes elsewhere")
    return folder
