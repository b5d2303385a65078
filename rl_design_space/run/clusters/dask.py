"""Learning on a Dask cluster."""

from __future__ import annotations

import asyncio
import logging
from contextlib import ExitStack
from queue import Empty, Queue
from tempfile import TemporaryDirectory
from typing import Any

from rl_design_space.config.user_config import module_folders
from rl_design_space.learning.version import KERNEL_VERSION
from rl_design_space.run.clusters.chunks import Cluster, Results
from rl_design_space.run.clusters.cluster_executor import CONNECT_TIMEOUT, ClusterExecutor, unreachable, unusable
from rl_design_space.run.clusters.worker import learn_chunk

#: Config of a local cluster: when a worker dies, its chunk fails at once, and no other chunk is queued at that worker,
#: which would fail with it. Nothing is served over HTTP, where anyone could read it.
_CONFIG = {
    "distributed.scheduler.allowed-failures": 0,
    "distributed.scheduler.worker-saturation": 1.0,
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}
#: Loggers that set their own levels; errors are reported with the result that they concern.
_LOGGERS = ("distributed", "distributed.client", "distributed.gc")
#: Seconds to wait for a worker to end.
_KILL_TIMEOUT = 0.5


class DaskExecutor(ClusterExecutor):
    """Learns on the workers of a Dask cluster; see `ClusterExecutor`."""

    name, extra, module = "Dask", "dask", "distributed"
    addresses = "tcp://node1:8786"

    def start(self) -> Cluster:
        return _DaskCluster(self._library, self._address, self._threads)


class _DaskCluster:
    """A client, and its cluster if that was started here."""

    def __init__(self, distributed: Any, address: str | None, threads: int) -> None:
        self._distributed, self._address = distributed, address
        self._done: Queue[Any] = Queue()
        for name in _LOGGERS:
            logging.getLogger(name).setLevel(logging.CRITICAL)
        with ExitStack() as stack:
            try:
                target = address or _local_cluster(distributed, threads, stack)
                self._client = distributed.Client(target, timeout=CONNECT_TIMEOUT, set_as_default=False)
            except OSError as error:
                raise unreachable(str(address), error) from error
            stack.callback(self._client.close)
            self._stack = stack.pop_all()

    @property
    def workers(self) -> int:
        try:
            return sum(self._client.nthreads().values())
        except Exception as error:
            raise unusable(self._address, error) from error

    def submit(self, points: list[bytes]) -> Any:
        future = self._client.submit(learn_chunk, points, KERNEL_VERSION, module_folders(), pure=False)
        future.add_done_callback(self._done.put)
        return future

    def wait(self, seconds: float) -> list[tuple[Any, Results | None]]:
        try:
            future = self._done.get(timeout=seconds)
        except Empty:
            return []
        try:
            return [(future, future.result())]
        except self._distributed.KilledWorker:
            return [(future, None)]
        except Exception as error:
            raise unusable(self._address, error) from error

    def close(self) -> None:
        self._stack.close()


def _local_cluster(distributed: Any, workers: int, stack: ExitStack) -> Any:
    """Start a cluster on this machine to which no other user of the machine can connect."""
    from dask import config

    folder = stack.enter_context(TemporaryDirectory(prefix="dask-", ignore_cleanup_errors=True))
    with config.set({**_CONFIG, "temporary-directory": folder}):
        cluster = distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address=None,
            # Dask opens a dashboard port even so; port 0 chooses a free one.
            scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},
            silence_logs=logging.CRITICAL,
            # A connection can run code. Only processes of this cluster have its certificate, which is kept in memory.
            security=distributed.Security.temporary(),
            memory_limit=0,
        )
    stack.callback(cluster.close)
    stack.callback(_end_workers, cluster)
    return cluster


def _end_workers(cluster: Any) -> None:
    """Kill the workers of a local cluster: on a regular stop, they would finish their chunks first."""

    async def end() -> None:
        ending = (nanny.kill(timeout=_KILL_TIMEOUT) for nanny in cluster.workers.values())
        await asyncio.gather(*ending, return_exceptions=True)

    cluster.sync(end)
