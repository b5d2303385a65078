"""Launchers that learn design points: `hydra/launcher=design`, `design_dask`, `design_ray`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from hydra._internal.core_plugins.basic_launcher import BasicLauncher
from hydra.core.utils import JobReturn

if TYPE_CHECKING:
    from rl_design_space.run.executor import Executor


class DesignLauncher(BasicLauncher):
    """Learns design points on the threads of this process; runs jobs of other applications one after the other.

    Args:
        dumps: whether the resolved config and the overrides of each point are written to a folder of its own.
    """

    def __init__(self, dumps: bool = False) -> None:
        super().__init__()
        self.dumps = dumps

    def executor(self, threads: int) -> Executor:
        """Return the executor that learns the points.

        Args:
            threads: number of threads that learn on this machine.
        """
        from rl_design_space.run.local_executor import LocalExecutor

        return LocalExecutor(threads)

    def launch(self, job_overrides: Sequence[Sequence[str]], initial_job_idx: int) -> Sequence[JobReturn]:
        """Run the jobs of another sweeper."""
        # Do not import it: that would set the Hydra version of another application.
        ours = sys.modules.get("rl_design_space.commands.application")
        if ours is None or self.task_function is not getattr(ours.application, "__wrapped__", None):
            return super().launch(job_overrides, initial_job_idx)
        from rl_design_space.commands.foreign_sweep import launch

        assert self.config is not None
        return launch(job_overrides, self.config, self)


class DesignDaskLauncher(DesignLauncher):
    """Learns design points on a Dask cluster.

    Args:
        address: address of its scheduler; if None, a cluster is started on this machine.
        chunk: number of points per task; if None, few enough that all workers stay busy to the end.
    """

    def __init__(self, address: str | None = None, chunk: int | None = None, dumps: bool = False) -> None:
        super().__init__(dumps)
        self._address, self._chunk = address, chunk

    def executor(self, threads: int) -> Executor:
        from rl_design_space.run.clusters.dask import DaskExecutor

        return DaskExecutor(self._address, self._chunk, threads)


class DesignRayLauncher(DesignLauncher):
    """Learns design points on a Ray cluster.

    Args:
        address: address of the cluster; if None, a cluster is started on this machine.
        chunk: number of points per task; if None, few enough that all workers stay busy to the end.
    """

    def __init__(self, address: str | None = None, chunk: int | None = None, dumps: bool = False) -> None:
        super().__init__(dumps)
        self._address, self._chunk = address, chunk

    def executor(self, threads: int) -> Executor:
        from rl_design_space.run.clusters.ray import RayExecutor

        return RayExecutor(self._address, self._chunk, threads)
