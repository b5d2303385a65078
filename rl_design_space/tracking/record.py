"""What is recorded of a design point: plain values, ready for any store."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml

from rl_design_space._arrays import FloatArray
from rl_design_space.learning import LearningCurves
from rl_design_space.learning.names import CURVES
from rl_design_space.sweep.describe import resolved_config
from rl_design_space.sweep.plan import PlannedPoint
from rl_design_space.tracking import values
from rl_design_space.tracking.spool import POINT, Record

if TYPE_CHECKING:
    from rl_design_space.tracking.options import Kept

#: A run's tag for each study that it belongs to begins like this.
STUDY_TAG = "study."
#: Tags of ours: what identifies a point; the spool that a run is written from; the sweep that a summary run is of; why
#: a run is not complete.
FINGERPRINT_TAG, SPOOL_TAG = "fingerprint", "rl_design_space.spool"
SWEEP_TAG, INCOMPLETE_TAG = "rl_design_space.sweep", "rl_design_space.incomplete"
#: File names of a run's artifacts.
PERIODS_FILE, CONFIG_FILE = "periods.npz", "config.yaml"


def point_record(
    planned: PlannedPoint,
    learned: LearningCurves,
    origin: dict[str, str],
    *,
    curves: Sequence[str] = (),
    every: int = 1,
    keep: Kept = "periods",
    checked: bool = True,
) -> Record:
    """Everything that is told to a store about a point.

    Args:
        planned: the point.
        learned: its result.
        origin: tags that say who recorded it.
        curves: that are recorded beside those that always are.
        every: how many trials lie between two values of a recorded curve.
        keep: what the artifact holds.
        checked: whether the store is known not to have the point.

    Raises:
        ConfigError: MLflow would not take a name.
    """
    scalars = learned.scalars(planned.point.world.shape)
    content = {
        "name": planned.name,
        "started": int((time.time() - learned.seconds) * 1000),
        "tags": {**study_tags(planned.studies), **origin},
        "params": params(planned),
        "metrics": metrics(learned, scalars, curves, every),
        "scalars": {name: value for name, value, step in metrics(learned, scalars, (), every) if name in scalars},
        "checked": checked,
    }
    artifacts = {CONFIG_FILE: config_file(planned), PERIODS_FILE: periods_file(learned, keep)}
    return Record(POINT, planned.fingerprint, content, artifacts)


def study_tags(studies: Iterable[str]) -> dict[str, str]:
    """A tag for each study.

    Raises:
        ConfigError: MLflow would not take the name of a study.
    """
    return {values.key(f"{STUDY_TAG}{study}"): "true" for study in studies}


def params(planned: PlannedPoint) -> dict[str, str]:
    """Every choice, flat and dotted, as typed on the command line."""
    return {values.key(name): values.param(value) for name, value in planned.parameters.items()}


def metrics(
    learned: LearningCurves, scalars: dict[str, float], on_demand: Iterable[str], every: int = 1
) -> list[tuple[str, float, int]]:
    """Scalars at step 0 and learning curves at step = trial, as (name, value, step); only finite values.

    Of a curve, every so many trials are taken, and the last one.
    """
    found = learned.curves
    points = [(values.key(name), value, 0) for name, value in scalars.items()]
    for name in dict.fromkeys((*CURVES, *on_demand)):
        curve = found[values.key(name)].tolist()
        trials = sorted({*range(0, len(curve), every), len(curve) - 1})
        points += [(name, curve[trial], trial) for trial in trials]
    numbers = [(name, values.metric(value), step) for name, value, step in points]
    return [(name, number, step) for name, number, step in numbers if number is not None]


def config_file(planned: PlannedPoint) -> bytes:
    """The resolved config, every value written out, under the command that runs the point."""
    text = yaml.safe_dump(resolved_config(planned.point), sort_keys=False, allow_unicode=True)
    return f"# {planned.command}\n{text}".encode()


def periods_file(learned: LearningCurves, keep: Kept = "periods") -> bytes:
    """The steps of every trial of every period, and all curves; or the curves alone.

    The steps are uint16 where the step cap fits, which halves the file; `success` tells a trial that ended
    at the cap from one that was cut there.
    """
    width: type[np.unsignedinteger[Any]] = np.uint16 if learned.steps.max() <= np.iinfo(np.uint16).max else np.uint32
    periods: dict[str, Any] = {
        "steps": learned.steps.astype(width),
        "success": learned.success,
        "optimum": learned.optimum,
        "rows": learned.rows,
    }
    curves: dict[str, Any] = {f"curve:{name}": curve for name, curve in learned.curves.items()}
    buffer = BytesIO()
    np.savez(buffer, **(periods if keep == "periods" else {}), **curves)
    return buffer.getvalue()


def read_periods(path: Path) -> dict[str, FloatArray]:
    """The arrays of a `PERIODS_FILE`, by name."""
    with np.load(path) as archive:
        return {name.replace("curve:", ""): archive[name] for name in archive.files}
