"""Re-run a recorded point and compare the results bit for bit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rl_design_space.config.recorded import recorded_point
from rl_design_space.design import DesignPoint
from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.plan.fingerprint import fingerprint
from rl_design_space.tracking.found_run import FoundRun
from rl_design_space.tracking.run_files import DamagedFileError, check_config, check_periods
from rl_design_space.tracking.selection import named
from rl_design_space.tracking.tags import EXTERNAL_TAG, FINGERPRINT_TAG
from rl_design_space.tracking.tracker import StoredRun

if TYPE_CHECKING:
    from rl_design_space.tracking.read import RunReader

#: The arrays that are compared; all other results follow from them.
_COMPARED = ("steps", "success", "optimum", "rows", "epsilon")


@dataclass(frozen=True)
class Comparison:
    """The comparison of a recorded run with a new run of its point.

    Attributes:
        same: whether the results are identical, bit for bit.
        text: the result as a message.
    """

    same: bool
    text: str


def compare(reader: RunReader, run_id: str, threads: int | None) -> Comparison:
    """Learn the point of a run again, from the config that the run holds, and compare the results.

    Args:
        reader: reads the store.
        run_id: id of the run, or a prefix of it.
        threads: number of threads that learn; all cores if None.

    Raises:
        ConfigError: no run or several runs match, the run does not hold its periods, or its config is not accepted.
    """
    found = named(reader.runs(), run_id)
    if learner := found.tags.get(EXTERNAL_TAG):
        raise ConfigError(f"{found.run_id}: was measured by {learner}, a program of yours; only that can repeat it")
    run = StoredRun(found.run_id, artifacts=found.artifacts)
    recorded = reader.periods(run)
    if "steps" not in recorded:
        raise ConfigError(
            f"{run.run_id}: holds its curves only (tracking.artifact=curves), so its periods cannot be compared"
        )
    config = reader.config(run)
    point = recorded_point(config, f"run {run.run_id}")
    check_config(found, config)
    curves = simulate(point, threads)
    different = [name for name in _COMPARED if not _equal(recorded[name], getattr(curves, name))]
    what = f"{found.name} (run {run.run_id})"
    if not different:
        return Comparison(True, f"identical: {what}, {curves.steps.size:,} trials, bit for bit")
    return Comparison(False, f"different: {what}, in {', '.join(different)}{_why(found, point, recorded)}")


def _equal(one: NDArray[Any], other: NDArray[Any]) -> bool:
    return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")


def _why(found: FoundRun, point: DesignPoint, recorded: Mapping[str, NDArray[Any]]) -> str:
    """Return why a result may be another one, if something is known."""
    if fingerprint(point) != found.tags.get(FINGERPRINT_TAG):
        return "; the code that it depends on has changed since"
    try:
        check_periods(found, recorded)
    except DamagedFileError as error:
        return f"; {error.file} is damaged: {error.reason}"
    return ""
