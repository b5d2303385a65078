"""Re-run a recorded point and compare the results bit for bit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rl_design_space.config.recorded import recorded_point
from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.plan.fingerprint import fingerprint
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
    frame = reader.frame()
    found = frame[frame.index.str.startswith(run_id)] if run_id else frame[:0]
    if len(found) != 1:
        how_many = "no complete run has" if found.empty else f"{len(found)} runs have"
        raise ConfigError(f"{run_id}: {how_many} an id that begins with this")
    row = found.iloc[0]
    run = StoredRun(str(found.index[0]), artifacts=str(row["artifacts"]))
    recorded = reader.periods(run)
    if "steps" not in recorded:
        raise ConfigError(
            f"{run.run_id}: holds its curves only (tracking.artifact=curves), so its periods cannot be compared"
        )
    point = recorded_point(reader.config(run), f"run {run.run_id}")
    curves = simulate(point, threads)
    different = [name for name in _COMPARED if not np.array_equal(recorded[name], getattr(curves, name))]
    what = f"{row['name']} (run {run.run_id})"
    if not different:
        return Comparison(True, f"identical: {what}, {curves.steps.size:,} trials, bit for bit")
    why = "" if fingerprint(point) == row["fingerprint"] else "; the code that it depends on has changed since"
    return Comparison(False, f"different: {what}, in {', '.join(different)}{why}")
