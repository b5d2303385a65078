"""What is kept of a design point until the store has it: plain values, and the result as it was learned.

Threads that learn have to share their process with whoever makes a record, so this does no more than it must; what the
store is told is worked out by who tells it, see `content`.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from io import BytesIO

import numpy as np

from rl_design_space.learning.result import Kept, LearningCurves
from rl_design_space.plan.describe import resolved_config
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.tracking import values
from rl_design_space.tracking.spool import POINT, Record

#: A run's tag for each study that it belongs to begins like this.
STUDY_TAG = "study."
#: Tags of ours: what identifies a point; the spool that a run is written from; the sweep that a summary run is of; why
#: a run is not complete.
FINGERPRINT_TAG, SPOOL_TAG = "fingerprint", "rl_design_space.spool"
SWEEP_TAG, INCOMPLETE_TAG = "rl_design_space.sweep", "rl_design_space.incomplete"
#: The file of a record that holds the result; what it began with in an earlier version.
_RESULT, _NPY = "result", b"\x93NUMPY"


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
    """All that a store will be told about a point follows from this.

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
    scalars = learned.scalars()
    numbers = {values.key(name): values.metric(value) for name, value in scalars.items()}
    content = {
        "name": planned.name,
        "started": int((time.time() - learned.seconds) * 1000),
        "seconds": learned.seconds,
        "tags": {**study_tags(planned.studies), **origin},
        "params": params(planned),
        "command": planned.command,
        "config": resolved_config(planned.point),
        "scalars": {name: number for name, number in numbers.items() if number is not None},
        "curves": list(curves),
        "every": every,
        "keep": keep,
        "checked": checked,
    }
    return Record(POINT, planned.fingerprint, content, {_RESULT: _packed(learned)})


def result_of(record: Record) -> LearningCurves:
    """Return the result in a point's record; its point is not built, for its code may not be on this machine."""
    content, seconds = BytesIO(record.files[_RESULT]), record.content["seconds"]
    if not record.files[_RESULT].startswith(_NPY):
        return LearningCurves.load(content, seconds=seconds)
    # Version 0.1.0 wrote the arrays one after the other.
    arrays = {name: np.load(content) for name in ("steps", "success", "optimum", "rows", "epsilon")}
    return LearningCurves.of_arrays(arrays, seconds=seconds)


def study_tags(studies: Iterable[str]) -> dict[str, str]:
    """A tag for each study.

    Raises:
        ConfigError: MLflow would not take the name of a study.
    """
    return {values.key(f"{STUDY_TAG}{study}"): "true" for study in studies}


def params(planned: PlannedPoint) -> dict[str, str]:
    """Every choice, flat and dotted, as typed on the command line."""
    return {values.key(name): values.param(value) for name, value in planned.parameters.items()}


def _packed(learned: LearningCurves) -> bytes:
    buffer = BytesIO()
    learned.save(buffer, compress=False)
    return buffer.getvalue()
