"""What is kept of a design point until the store has it: plain values, and the result as it was learned.

Threads that learn have to share their process with whoever makes a record, so this does no more than it must; what the
store is told is worked out by who tells it, see `content`.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from io import BytesIO
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from rl_design_space.learning import LearningCurves
from rl_design_space.plan.describe import resolved_config
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.tracking import values
from rl_design_space.tracking.spool import POINT, Record

#: What a run's artifact keeps: everything, or the curves alone.
Kept = Literal["periods", "curves"]
#: A run's tag for each study that it belongs to begins like this.
STUDY_TAG = "study."
#: Tags of ours: what identifies a point; the spool that a run is written from; the sweep that a summary run is of; why
#: a run is not complete.
FINGERPRINT_TAG, SPOOL_TAG = "fingerprint", "rl_design_space.spool"
SWEEP_TAG, INCOMPLETE_TAG = "rl_design_space.sweep", "rl_design_space.incomplete"
#: The file of a record that holds the result, and the arrays in it, one after the other.
_RESULT, _ARRAYS = "result", ("steps", "success", "optimum", "rows", "epsilon")


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
    scalars = learned.scalars(planned.point.world.shape)
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
    """The result in a point's record."""
    buffer = BytesIO(record.files[_RESULT])
    arrays: dict[str, Any] = {name: np.load(buffer) for name in _ARRAYS}
    arrays["steps"] = arrays["steps"].astype(np.int32)
    return LearningCurves(**arrays, seconds=record.content["seconds"])


def narrow(steps: NDArray[np.int32]) -> NDArray[np.unsignedinteger[Any]]:
    """Steps as uint16 where they fit, which halves a file, else as uint32."""
    return steps.astype(np.uint16 if steps.max() <= np.iinfo(np.uint16).max else np.uint32)


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
    for name in _ARRAYS:
        array = getattr(learned, name)
        np.save(buffer, narrow(array) if name == "steps" else array)
    return buffer.getvalue()
