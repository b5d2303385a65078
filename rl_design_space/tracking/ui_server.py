"""A server of MLflow's UI that listens on this machine only, with as few processes as MLflow allows."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from http.client import HTTPException
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO
from urllib.error import URLError
from urllib.request import urlopen

from rl_design_space.errors import ConfigError
from rl_design_space.tracking import ui_guard

_HOST = "127.0.0.1"
#: Environment of the server: no processes that execute jobs, no telemetry.
_LEAN = {
    "MLFLOW_SERVER_ENABLE_JOB_EXECUTION": "false",
    "MLFLOW_DISABLE_TELEMETRY": "true",
    "DO_NOT_TRACK": "true",
}
#: Seconds that a server may take to start; seconds between two checks.
_START, _PAUSE = 180, 0.2
#: Bytes and lines of the end of the server's log that are shown if it does not start.
_LOG_BYTES, _LOG_LINES = 20_000, 15


@contextmanager
def serving(uri: str, port: int, artifacts: Path) -> Iterator[str]:
    """Serve the UI of a tracking store until the block ends; no process is left behind, however this one ends.

    Args:
        uri: of a store that exists.
        port: port to listen on.
        artifacts: folder for the artifacts of experiments that are created through the server.

    Yields:
        The address, as soon as the server answers.

    Raises:
        ConfigError: the port is taken, or the server does not start.
    """
    _check_free(port)
    address = f"http://{_HOST}:{port}"
    with TemporaryFile() as log:
        guard = _start(uri, port, artifacts, log)
        try:
            _wait(guard, f"{address}/health", log)
            yield address
        finally:
            _end(guard)


def _check_free(port: int) -> None:
    with socket.socket() as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((_HOST, port))
        except (OSError, OverflowError) as error:
            reason = error.strerror if isinstance(error, OSError) else "not a valid port number"
            raise ConfigError(f"--port {port}: cannot be used ({reason}); give another, e.g. --port 5001") from error


def _start(uri: str, port: int, artifacts: Path, log: IO[bytes]) -> subprocess.Popen[bytes]:
    """Start a server, and return the process that guards it, see `ui_guard`."""
    words = ["server", "--host", _HOST, "--port", str(port), "--workers", "1"]
    # The URI is passed through the environment: it may hold a password, and arguments are visible to other users.
    environment = {**os.environ, **_LEAN, "MLFLOW_BACKEND_STORE_URI": uri}
    server = [sys.executable, "-m", "mlflow", *words, "--artifacts-destination", artifacts.absolute().as_uri()]
    return subprocess.Popen(
        # Run as a file, it imports nothing of this package and takes a tenth of the memory.
        [sys.executable, "-P", ui_guard.__file__, *server],
        stdin=subprocess.PIPE,
        stdout=log,
        stderr=subprocess.STDOUT,
        env=environment,
        # A process group of its own: Ctrl-C does not reach it, and it can be ended with all its children.
        start_new_session=True,
    )


def _wait(guard: subprocess.Popen[bytes], health: str, log: IO[bytes]) -> None:
    deadline = time.monotonic() + _START
    while guard.poll() is None and time.monotonic() < deadline:
        with suppress(URLError, HTTPException, OSError), urlopen(health, timeout=1):
            return
        time.sleep(_PAUSE)
    # The position is shared with the server, which may still write.
    size = os.fstat(log.fileno()).st_size
    text = os.pread(log.fileno(), _LOG_BYTES, max(0, size - _LOG_BYTES)).decode(errors="replace")
    last = text.splitlines()[-_LOG_LINES:]
    raise ConfigError("\n".join(["MLflow's server did not start; the end of its log:", *last]))


def _end(guard: subprocess.Popen[bytes]) -> None:
    """Have the guard end the server and itself."""
    assert guard.stdin
    guard.stdin.close()
    with suppress(subprocess.TimeoutExpired):
        guard.wait(ui_guard.GRACE + _PAUSE)
    with suppress(ProcessLookupError):
        os.killpg(guard.pid, signal.SIGKILL)
    guard.wait()
