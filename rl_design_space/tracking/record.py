"""The record of a design point: plain values, and its result.

It is made in the process whose threads learn, so it does no more than it must; what the run holds is derived from it by
the process that delivers it, see `content`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from io import BytesIO
from typing import Any

import numpy as np

from rl_design_space.learning.precision import Precision
from rl_design_space.learning.result import Kept, LearningCurves
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.tracking import values
from rl_design_space.tracking.spool import POINT, Record
from rl_design_space.tracking.tags import EXTERNAL_TAG, PRECISION_TAG, enough_of, precision_tags, studies_of, study_tags
from rl_design_space.tracking.tracker import Enough, StoredRun, enough_periods

#: The file of a record that holds the result; the first bytes of that file in version 0.1.0.
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
    """Return a record from which everything follows that the run of a point holds.

    Args:
        planned: the point.
        learned: its result.
        origin: tags that say who recorded it.
        curves: names of the curves to record in addition to `measures.CURVES`.
        every: number of trials from one recorded value of a curve to the next.
        keep: what the artifact holds.
        checked: whether the store is known not to have the point.

    Raises:
        ConfigError: MLflow would refuse a name.
    """
    rule = Precision.of_task(planned.point.task)
    run, tags = planned, {**study_tags(planned.studies), **origin}
    scalars = learned.scalars()
    if rule:
        run = planned.with_periods(len(learned.steps))
        reached, enough = rule.reached(learned), enough_periods(planned.point.task, learned)
        assert enough
        tags |= precision_tags(planned.fingerprint, enough, _in_words(rule, reached, enough))
        scalars[PRECISION_TAG] = reached
    numbers = {values.key(name): values.metric(value) for name, value in scalars.items()}
    seconds = 0.0 if math.isnan(learned.seconds) else learned.seconds
    started, ended = _times(planned, learned, seconds)
    chosen = run.parameters
    external = {EXTERNAL_TAG: values.tag(planned.measured_by)} if planned.measured_by else {}
    content = {
        "fingerprint": run.fingerprint,
        "name": run.run_name(chosen),
        "started": started,
        "ended": ended,
        # Sets this record apart from an earlier one of the same result, whose run was deleted.
        "recorded": int(1000 * time.time()),
        "seconds": seconds,
        "tags": {**tags, **external},
        "params": params(chosen),
        "command": run.command,
        "config": run.config,
        "scalars": {name: number for name, number in numbers.items() if number is not None},
        "curves": list(curves),
        "every": every,
        "keep": keep,
        # The store was not asked for a point with as many periods as turned out to be enough.
        "checked": checked and not rule,
    }
    return Record(POINT, planned.fingerprint, content, {_RESULT: _packed(learned)})


def fingerprint_of(record: Record) -> str:
    """Return the fingerprint of the run of a point; the key of the record is another one if it asks for a precision."""
    fingerprint: str = record.content.get("fingerprint", record.key)
    return fingerprint


def pending_run(record: Record) -> StoredRun:
    """Return the run of a point whose record is pending."""
    tags = record.content["tags"]
    return StoredRun("", studies_of(tags), record.content["scalars"], enough=enough_of(tags, record.key))


def result_of(record: Record) -> LearningCurves:
    """Return the result in a point's record, without its point, whose code may not be on this machine."""
    content, seconds = BytesIO(record.files[_RESULT]), record.content["seconds"]
    if not record.files[_RESULT].startswith(_NPY):
        return LearningCurves.load(content, seconds=seconds)
    # Version 0.1.0 wrote the arrays one after the other.
    arrays = {name: np.load(content) for name in ("steps", "success", "optimum", "rows", "epsilon")}
    return LearningCurves.of_arrays(arrays, seconds=seconds)


def ended_at(record: Record) -> int:
    """Return when the learning of a point ended, in milliseconds since 1970."""
    content = record.content
    if "ended" not in content:  # of an earlier version, which took the time of recording for the end of learning
        return int(content["started"] + 1000 * content["seconds"])
    return int(content["ended"])


def params(parameters: Mapping[str, Any]) -> dict[str, str]:
    """Return every choice of a point by its dotted name, as typed on the command line."""
    return {values.key(name): values.param(value) for name, value in parameters.items()}


def _times(planned: PlannedPoint, learned: LearningCurves, seconds: float) -> tuple[int, int]:
    """Return when the learning of this run started and ended: that of periods which were recorded before is left out.

    Returns:
        Both in milliseconds since 1970.
    """
    ended = time.time() if math.isnan(learned.ended_at) else learned.ended_at
    before = 0.0 if planned.begun is None or math.isnan(planned.begun.seconds) else planned.begun.seconds
    return int(1000 * (ended - max(0.0, seconds - before))), int(1000 * ended)


def _in_words(rule: Precision, reached: float, enough: Enough) -> str:
    wanted = f"{rule.of} to ± {rule.relative:.2%} at 95 %, at most {rule.at_most:,} periods"
    return f"{wanted}: {'' if enough.is_reached else 'not '}reached, ± {reached:.2%} with {enough.periods:,} periods"


def _packed(learned: LearningCurves) -> bytes:
    buffer = BytesIO()
    learned.save(buffer, compress=False)
    return buffer.getvalue()
