"""The interface of launchers that learn design points instead of running jobs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from typing_extensions import Protocol, runtime_checkable

if TYPE_CHECKING:
    from rl_design_space.run.executor import Executor


@runtime_checkable
class PointLauncher(Protocol):
    """A Hydra launcher that learns design points.

    Attributes:
        dumps: whether the resolved config and the overrides of each point are written to a folder of its own.
    """

    dumps: bool

    def executor(self, threads: int) -> Executor:
        """Return the executor that learns the points, with this many threads on this machine."""
        ...
