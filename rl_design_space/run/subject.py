"""The design point that a command looks at: of a recorded run, or of overrides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rl_design_space.config.recorded import recorded_point
from rl_design_space.design import DesignPoint
from rl_design_space.errors import ConfigError
from rl_design_space.plan.planner import plan_point
from rl_design_space.tracking.run_files import check_config
from rl_design_space.tracking.tags import FINGERPRINT_TAG
from rl_design_space.tracking.tracker import StoredRun

if TYPE_CHECKING:
    from rl_design_space.tracking.found_run import FoundRun
    from rl_design_space.tracking.read import RunReader

#: Digits of an id that name files.
_DIGITS = 8


@dataclass(frozen=True)
class Subject:
    """A design point to look at.

    Attributes:
        point: the design point.
        name: its overrides.
        key: beginning of its run id, or of its fingerprint, for names of files.
        steps: (periods, trials) recorded steps; None if none are recorded.
    """

    point: DesignPoint
    name: str
    key: str
    steps: NDArray[np.int32] | None = None


def of_overrides(overrides: Sequence[str]) -> Subject:
    """Return the point that these overrides describe.

    Raises:
        ConfigError: an override is not understood or its value is not allowed.
    """
    planned = plan_point(overrides)
    return Subject(planned.point, planned.name, planned.fingerprint[:_DIGITS])


def of_run(reader: RunReader, text: str) -> Subject:
    """Return the point of a recorded run.

    Args:
        reader: reads the store.
        text: id of the run, or fingerprint of its point, or a prefix of either.

    Raises:
        ConfigError: no run or several runs match, or the config of the run is not accepted.
    """
    found = _found(reader.runs(), text)
    run = StoredRun(found.run_id, artifacts=found.artifacts)
    config = reader.config(run)
    point = recorded_point(config, f"run {run.run_id}")
    check_config(found, config)
    return Subject(point, found.name, found.run_id[:_DIGITS], reader.periods(run).get("steps"))


def _found(runs: Sequence[FoundRun], text: str) -> FoundRun:
    found = [run for run in runs if text and run.run_id.startswith(text)]
    found = found or [run for run in runs if text and run.tags.get(FINGERPRINT_TAG, "").startswith(text)]
    if len(found) != 1:
        how_many = f"{len(found)} runs have" if found else "no complete run has"
        raise ConfigError(
            f"{text}: {how_many} an id or fingerprint that begins with this; overrides look like key=value, such as "
            "representation=direction"
        )
    return found[0]
