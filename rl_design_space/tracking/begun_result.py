"""Reading the result of a recorded run that is continued."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping

from rl_design_space.errors import ConfigError
from rl_design_space.learning.result import LearningCurves
from rl_design_space.tracking.found_run import FoundRun
from rl_design_space.tracking.read import RunReader
from rl_design_space.tracking.record import result_of
from rl_design_space.tracking.run_files import check_periods
from rl_design_space.tracking.spool import CorruptedRecordError, Spool, point_name
from rl_design_space.tracking.store_errors import StoreUnavailableError
from rl_design_space.tracking.tracker import Beginning, StoredRun


def begun_result(
    beginning: Beginning, trials: int, spool: Spool, find: Callable[[Collection[str]], Mapping[str, StoredRun]]
) -> LearningCurves | None:
    """Return the result of a recorded run; None if it cannot be read, or is not what was recorded.

    Args:
        beginning: the run.
        trials: number of trials of the point.
        spool: with the pending records of the store that the run is in.
        find: returns the runs of those of these fingerprints that the store has.
    """
    run: StoredRun | None = beginning.run
    if not beginning.run.run_id:
        try:
            return result_of(spool.read(point_name(beginning.fingerprint)))
        except FileNotFoundError:  # delivered in the meantime
            run = find([beginning.fingerprint]).get(beginning.fingerprint)
        except (CorruptedRecordError, ValueError, LookupError, OSError):
            return None
    return _recorded(run, beginning.periods, trials, spool) if run else None


def _recorded(run: StoredRun, periods: int, trials: int, spool: Spool) -> LearningCurves | None:
    params = {"task.periods": str(periods), "task.trials": str(trials)}
    try:
        arrays = RunReader(spool.address).periods(run)
        check_periods(FoundRun(run.run_id, "", 0, 0, run.artifacts, params, dict(run.scalars)), arrays)
        return LearningCurves.of_arrays(arrays, seconds=_seconds(run, periods))
    except (ConfigError, StoreUnavailableError, LookupError):  # damaged, not here, or its learning curves alone
        return None


def _seconds(run: StoredRun, periods: int) -> float:
    """Return the wall time of learning of a run, which follows from its rate; NaN if that is not recorded."""
    total, rate = (run.scalars.get(name, 0.0) for name in ("total_steps", "env_steps_per_second"))
    return total * periods / rate if rate else math.nan
