"""The command `rl-design-space` with points that learn nothing, to see what else a point costs.

`python -m benchmarks.noop ARGUMENTS` ends with a line of JSON: CPU seconds and resident memory of the process.
"""

from __future__ import annotations

import json
import os
import resource
import sys
from functools import cache
from typing import Any

import numpy as np

from rl_design_space.commands import cli, sweep_output
from rl_design_space.design import DesignPoint
from rl_design_space.learning import LearningCurves, simulation


class _Nothing:
    """Stands for learning: there is nothing to do, and the curves are ready."""

    has_work = False

    def __init__(self, point: DesignPoint, threads: int = 1, begun: LearningCurves | None = None) -> None:
        self._periods = point.task.periods

    def work(self) -> bool:
        return True

    def stop(self) -> None:
        pass

    def curves(self) -> LearningCurves:
        return _curves(self._periods)


@cache
def _curves(periods: int) -> LearningCurves:
    """Return curves of as many periods as a point asks for; with fewer, it would be learned on."""
    return LearningCurves(
        steps=np.ones((periods, 10), dtype=np.int32),
        success=np.ones((periods, 10), dtype=np.bool_),
        optimum=np.ones(periods, dtype=np.int32),
        rows=np.ones((periods, 2), dtype=np.int32),
        epsilon=np.zeros(10),
        seconds=1e-6,
    )


def _resident() -> int:
    """Bytes of memory that the process occupies now."""
    with open("/proc/self/statm", encoding="ascii") as file:  # noqa: PTH123 - a file of the system, not of ours
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def _report() -> None:
    used = resource.getrusage(resource.RUSAGE_SELF)
    figures = {"cpu": used.ru_utime + used.ru_stime, "bytes": _resident()}
    print(json.dumps(figures), file=sys.stderr)


def main() -> None:
    """Run the command, and report while everything it keeps is still there."""
    simulation.Learning = _Nothing  # type: ignore[assignment, misc]
    simulation.simulate = lambda point, threads=None, **_: _curves(point.task.periods)
    # A sweep of ours holds most when it shows its outcome, a sweep of Hydra's when it ends.
    show, reported = sweep_output.show_outcome, False

    def show_and_report(*arguments: Any) -> None:
        nonlocal reported
        show(*arguments)
        _report()
        reported = True

    sweep_output.show_outcome = show_and_report  # type: ignore[assignment]
    cli.main()
    if not reported:
        _report()


if __name__ == "__main__":
    main()
