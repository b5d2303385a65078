"""The parent's end of a worker: starts a peer in its own process and talks to it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryFile
from threading import Timer
from time import perf_counter
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from benchmarks.job import Job
from benchmarks.peers import Missing

ROOT = Path(__file__).parents[1]
#: Seconds that any process may take before it is ended.
LIMIT = 3600.0

#: One thread for every library that would otherwise take all cores.
_ONE_THREAD = {
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"),
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
    "JAX_PLATFORMS": "cpu",
}


class WorkerError(Exception):
    """A peer raised an exception or died."""


class Timed(NamedTuple):
    """What a call took and, of a call that learns, the total steps of every period."""

    seconds: float
    total: NDArray[np.int64]
    peak_mib: float


@contextmanager
def pinned(core: int | None) -> Iterator[None]:
    """Keep this thread, and all that it starts, on one core; None, or a system that cannot: wherever they like."""
    if core is None or not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {core})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def last_core() -> int | None:
    """The core to measure on. The last, because systems put their own work on the first."""
    return max(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else None


class Worker:
    """A peer in its own process, on one core, so that imports, compilation and memory are its own.

    Args:
        name: of the peer, see `benchmarks.peers.load`.
        cache: empty folder for compiled code, so that what is measured has not been compiled before; None for that of
            all other processes.
        python: the interpreter; a peer whose requirements conflict with ours can have its own.

    Raises:
        Missing: the peer cannot run here.
        WorkerError: it died.
    """

    def __init__(self, name: str, cache: Path | None, python: str = sys.executable) -> None:
        self._errors = TemporaryFile("w+")  # noqa: SIM115 (closed with the worker)
        environment = {**os.environ, **_ONE_THREAD, **({} if cache is None else {"NUMBA_CACHE_DIR": str(cache)})}
        started = perf_counter()
        with pinned(last_core()):
            self._process = subprocess.Popen(
                [python, "-m", "benchmarks.worker", name],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors, text=True, cwd=ROOT,
                env=environment,
            )  # fmt: skip
        try:
            ready = self._reply()
            self.start_seconds = perf_counter() - started
            if "missing" in ready:
                raise Missing(ready["missing"])
        except BaseException:
            self.close()
            raise
        self.title: str = ready["title"]
        self.version: str = ready["version"]
        self.periods: int = ready["periods"]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.kill()
        self._process.wait(LIMIT)
        self._process.stdin.close()
        self._process.stdout.close()
        self._errors.close()

    def prepare(self, job: Job) -> Timed:
        """Make the peer ready for a job."""
        return self._request({"prepare": asdict(job)})

    def learn(self, layouts: NDArray[np.int32], seed: int) -> Timed:
        """Learn periods."""
        return self._request({"learn": layouts.tolist(), "seed": seed})

    def _request(self, message: dict[str, Any]) -> Timed:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(message) + "\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            pass  # reading tells why
        reply = self._reply()
        return Timed(reply["seconds"], np.array(reply["total"], dtype=np.int64), reply["peak_mib"])

    def _reply(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        timer = Timer(LIMIT, self._process.kill)
        timer.start()
        line = self._process.stdout.readline()
        timer.cancel()
        if not line:
            self._process.wait(LIMIT)
            self._errors.seek(0)
            said = self._errors.read().strip().splitlines()
            raise WorkerError(said[-1] if said else f"ended with status {self._process.returncode}")
        reply: dict[str, Any] = json.loads(line)
        return reply
