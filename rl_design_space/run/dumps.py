"""Dumps: files with the config and the overrides of each point."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import yaml

from rl_design_space.plan.describe import resolved_config
from rl_design_space.plan.plan import PlannedPoint


def write_dumps(points: Iterable[PlannedPoint], folder: Path) -> None:
    """Write `config.yaml` and `overrides.yaml`, as Hydra does for a job, into a folder for each point.

    Args:
        points: the points to dump.
        folder: parent of the folders, which are named after the fingerprints.
    """
    for planned in points:
        place = folder / planned.fingerprint
        place.mkdir(parents=True, exist_ok=True)
        for name, content in (("config", resolved_config(planned.point)), ("overrides", list(planned.overrides))):
            text = yaml.safe_dump(content, sort_keys=False, allow_unicode=True)
            (place / f"{name}.yaml").write_text(text, encoding="utf-8")
