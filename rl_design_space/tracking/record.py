"""What is recorded of a design point: plain values, ready for any store."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from rl_design_space._arrays import FloatArray
from rl_design_space.learning import LearningCurves
from rl_design_space.learning.names import CURVES
from rl_design_space.sweep.describe import resolved_config
from rl_design_space.sweep.plan import PlannedPoint

#: A run's tag for each study that it belongs to begins like this.
STUDY_TAG = "study."
#: File names of a run's artifacts.
PERIODS_FILE, CONFIG_FILE = "periods.npz", "config.yaml"


def params(planned: PlannedPoint) -> dict[str, str]:
    """Every choice, flat and dotted, as typed on the command line."""
    return {name: str(value) for name, value in planned.parameters.items()}


def metrics(
    curves: LearningCurves, scalars: dict[str, float], on_demand: Iterable[str]
) -> list[tuple[str, float, int]]:
    """Scalars at step 0 and learning curves at step = trial, as (name, value, step); only finite values."""
    every = curves.curves
    points = [(name, value, 0) for name, value in scalars.items()]
    for name in (*CURVES, *on_demand):
        points += [(name, value, trial) for trial, value in enumerate(every[name].tolist())]
    return [(name, value, step) for name, value, step in points if math.isfinite(value)]


def write_artifacts(folder: Path, planned: PlannedPoint, curves: LearningCurves) -> None:
    """Write the steps of every trial of every period, all curves, and the resolved config.

    The steps are uint16 where the step cap fits, which halves the file; `success` tells a trial that ended
    at the cap from one that was cut there.
    """
    width: type[np.unsignedinteger[Any]] = np.uint16 if curves.steps.max() <= np.iinfo(np.uint16).max else np.uint32
    arrays: dict[str, Any] = {
        "steps": curves.steps.astype(width),
        "success": curves.success,
        "optimum": curves.optimum,
        "rows": curves.rows,
        **{f"curve:{name}": values for name, values in curves.curves.items()},
    }
    np.savez_compressed(folder / PERIODS_FILE, **arrays)
    text = yaml.safe_dump(resolved_config(planned.point), sort_keys=False, allow_unicode=True)
    (folder / CONFIG_FILE).write_text(f"# {planned.command}\n{text}", encoding="utf-8")


def read_periods(path: Path) -> dict[str, FloatArray]:
    """The arrays of a `PERIODS_FILE`, by name."""
    with np.load(path) as archive:
        return {name.replace("curve:", ""): archive[name] for name in archive.files}
