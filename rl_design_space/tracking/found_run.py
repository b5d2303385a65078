"""What queries of a tracking store return."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class FoundRun:
    """A complete run, without its curves and files.

    Attributes:
        run_id: its id.
        name: the overrides of its point.
        started: milliseconds since 1970.
        ended: milliseconds since 1970.
        artifacts: URI of the folder of its files.
        params: every choice, by its name on the command line.
        metrics: last values by name.
        tags: values by name.
    """

    run_id: str
    name: str
    started: int
    ended: int
    artifacts: str
    params: dict[str, str] = field(default_factory=dict)
    metrics: dict[str, float] = field(default_factory=dict)
    tags: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class RunCounts:
    """Numbers of runs of an experiment.

    Attributes:
        finished: complete runs.
        others: incomplete runs by status.
        deleted: runs that were deleted and still take up space.
    """

    finished: int
    others: dict[str, int]
    deleted: int

    @classmethod
    def of(cls, runs: Mapping[tuple[str, str], int]) -> RunCounts:
        """Sum up numbers of runs by lifecycle stage (active, deleted) and status."""
        active = {status: count for (stage, status), count in runs.items() if stage == "active"}
        deleted = sum(count for (stage, _), count in runs.items() if stage == "deleted")
        return cls(active.pop("FINISHED", 0), active, deleted)
