"""Learning on a Ray cluster."""

from __future__ import annotations

import logging
import os
import secrets
import signal
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rl_design_space.config.user_config import module_folders
from rl_design_space.learning.version import KERNEL_VERSION
from rl_design_space.run.clusters.chunks import Cluster, Results
from rl_design_space.run.clusters.cluster_executor import ClusterExecutor, unreachable, unusable
from rl_design_space.run.clusters.worker import learn_chunk

#: No usage statistics; no changes of the variables that hide GPUs, of which Ray would warn; no output of workers: those
#: that die are reported with the result that they concern.
_ENVIRONMENT = {
    "RAY_USAGE_STATS_ENABLED": "0",
    "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0",
    "RAY_DEDUP_LOGS_SKIP_REGEX": ".",
}
#: Try an address that is no cluster once, not for minutes.
_REMOTE = {"RAY_NUM_REDIS_GET_RETRIES": "1"}
#: A local cluster listens on the loopback address only, which is not Ray's default on Linux, and requires a token.
_LOCAL = {"RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0", "RAY_AUTH_MODE": "token"}
#: Ray's folder holds its sockets, whose paths have to be short.
_SHORT = Path("/tmp")
#: The name of that folder, inside one that only this user can enter: Ray opens its own one to everybody.
_INNER = "r"


class RayExecutor(ClusterExecutor):
    """Learns on the workers of a Ray cluster; see `ClusterExecutor`."""

    name, extra, module = "Ray", "ray", "ray"
    addresses = "auto or node1:6379"
    symbolic = ("auto",)

    def __init__(self, address: str | None, chunk: int | None, threads: int) -> None:
        # Ray reads some of these when it is imported; the processes of a local cluster inherit all.
        os.environ.update(_ENVIRONMENT)
        if address is not None:
            os.environ.update(_REMOTE)
        else:
            # Without a token, Ray would create one and store it in the user's home.
            os.environ.update(_LOCAL, RAY_AUTH_TOKEN=secrets.token_hex(32))
        super().__init__(address, chunk, threads)

    def start(self) -> Cluster:
        return _RayCluster(self._library, self._address, self._threads)


class _RayCluster:
    """A connection to a cluster, and the cluster itself if it was started here."""

    def __init__(self, ray: Any, address: str | None, threads: int) -> None:
        self._ray, self._address = ray, address
        self._tasks: set[Any] = set()
        lost = ("WorkerCrashedError", "NodeDiedError", "OutOfMemoryError", "ObjectLostError")
        self._lost = tuple(getattr(ray.exceptions, name) for name in lost)
        with ExitStack() as stack:
            options = {} if address else _local_options(threads, stack)
            # This cancels tasks as well. Cancelling a task that has just ended may make Ray abort the process.
            stack.callback(ray.shutdown)
            on_term = signal.getsignal(signal.SIGTERM)
            try:
                ray.init(address or "local", log_to_driver=False, logging_level=logging.CRITICAL, **options)
            except Exception as error:
                raise unreachable(str(address), error) from error
            # Ray's own handler ends the process without any cleanup.
            signal.signal(signal.SIGTERM, on_term)
            self._stack = stack.pop_all()
        self._learn_chunk = ray.remote(max_retries=0)(learn_chunk)

    @property
    def workers(self) -> int:
        return int(self._ray.cluster_resources().get("CPU", 0))

    def submit(self, points: list[bytes]) -> Any:
        task = self._learn_chunk.remote(points, KERNEL_VERSION, module_folders())
        self._tasks.add(task)
        return task

    def wait(self, seconds: float) -> list[tuple[Any, Results | None]]:
        done, _ = self._ray.wait(list(self._tasks), timeout=seconds)
        self._tasks.difference_update(done)
        return [(task, self._results(task)) for task in done]

    def close(self) -> None:
        self._stack.close()

    def _results(self, task: Any) -> Results | None:
        try:
            results: Results = self._ray.get(task)
        except self._lost:
            return None
        except self._ray.exceptions.RayError as error:
            raise unusable(self._address, getattr(error, "cause", error)) from error
        return results


def _local_options(workers: int, stack: ExitStack) -> dict[str, Any]:
    parent = _SHORT if _SHORT.is_dir() else None
    folder = stack.enter_context(TemporaryDirectory(prefix="ray-", dir=parent, ignore_cleanup_errors=True))
    return {"num_cpus": workers, "num_gpus": 0, "include_dashboard": False, "_temp_dir": str(Path(folder) / _INNER)}
