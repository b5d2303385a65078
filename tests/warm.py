"""Commands in processes that have made their imports: a server imports what commands import, and forks for each.

Half of what a small command costs, and most of what a report costs, is importing libraries. Only libraries are imported
ahead: the package itself is imported by each command, in the environment of the command. A command gets arguments,
variables, a current folder and files for what it writes, as from a shell, and ends as the interpreter of a process
does. What differs from a new process: libraries that a command would not have needed are imported, libraries have read
the variables that they read when they are imported, garbage is collected more rarely, and the command line that the
system shows is that of the server.
"""

from __future__ import annotations

import atexit
import gc
import json
import os
import runpy
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path
from select import select
from typing import IO, Any
from warnings import catch_warnings, simplefilter

#: What is imported ahead: by learning, by reports, and by stores.
LIBRARIES = (
    *("hydra._internal.hydra", "numba.np.arraymath", "numpy", "pydantic", "rich.table", "scipy.linalg.cython_blas"),
    *("jinja2", "markdown_it", "matplotlib.backends.backend_agg", "matplotlib.pyplot", "pandas", "seaborn"),
    *("mlflow.store.tracking.rest_store", "mlflow.store.tracking.sqlalchemy_store"),
)
#: Variables of the server: they keep libraries from starting threads, which do not survive a fork.
_QUIET = {"MLFLOW_DISABLE_TELEMETRY": "true", "OPENBLAS_NUM_THREADS": "1"}
#: Seconds that the server may take to make its imports, and to fork.
_START = 240


class Warm:
    """The server, as the tests see it: they run one command at a time."""

    def __init__(self) -> None:
        inherited = {name: value for name, value in os.environ.items() if not name.startswith(("HYDRA_", "MLFLOW_"))}
        self._lock = threading.Lock()
        self._server = subprocess.Popen(
            [sys.executable, "-P", __file__],  # without the folder of tests, whose names are those of libraries
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**inherited, **_QUIET},
            bufsize=0,  # a line that has been read ahead could not be waited for
            start_new_session=True,
        )

    def run(
        self, command: Sequence[str], *, cwd: Path, env: Mapping[str, str], timeout: float
    ) -> subprocess.CompletedProcess[str]:
        """Run a command, the path of a Python script with arguments, as `subprocess.run` does.

        Raises:
            subprocess.TimeoutExpired: it took too long, and was killed.
        """
        with self._lock, tempfile.TemporaryDirectory() as folder:
            out, err = Path(folder) / "out", Path(folder) / "err"
            request = {"command": command, "cwd": str(cwd), "env": dict(env), "out": str(out), "err": str(err)}
            self._stream("stdin").write(f"{json.dumps(request)}\n".encode())
            process = self._answer(_START)
            try:
                status = self._answer(timeout)
            except BaseException:  # also what ends a test that takes too long
                os.kill(process, signal.SIGKILL)
                self._answer(timeout)
                raise
            return subprocess.CompletedProcess(
                command, status, out.read_text(encoding="utf-8"), err.read_text(encoding="utf-8")
            )

    def close(self) -> None:
        """End the server."""
        with suppress(BrokenPipeError):
            self._stream("stdin").close()
        self._server.wait(timeout=30)
        self._stream("stdout").close()

    def _answer(self, timeout: float) -> int:
        """Return the next number that the server writes, which it does only after a request."""
        stream = self._stream("stdout")
        if not select([stream], [], [], timeout)[0]:
            raise subprocess.TimeoutExpired(self._server.args, timeout)
        line = stream.readline()
        if not line:
            raise RuntimeError("the server of warm commands has ended")
        return int(line)

    def _stream(self, name: str) -> IO[bytes]:
        stream: IO[bytes] = getattr(self._server, name)
        return stream


@cache
def warm() -> Warm:
    """Return the server, which is started at first use and ends with these tests."""
    server = Warm()
    atexit.register(server.close)
    return server


def _serve() -> list[str]:
    """Import the libraries, then fork for every request.

    Returns:
        The command, in a process that is to run it.

    Raises:
        SystemExit: in the server, when there is no further request.
    """
    requests, answers = os.fdopen(os.dup(0)), os.fdopen(os.dup(1), "w")
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    os.dup2(nothing, 1)
    with catch_warnings():
        simplefilter("ignore")
        for name in LIBRARIES:
            import_module(name)
        _prepare_numba()
    gc.freeze()  # else collecting garbage copies all memory that processes share
    gc.set_threshold(50_000, 20, 20)  # as in the processes of tests
    for line in iter(requests.readline, ""):
        request = json.loads(line)
        with catch_warnings():
            simplefilter("ignore")  # Python 3.12 warns of threads, and Arrow has one for its memory
            process = os.fork()
        if not process:
            requests.close()
            answers.close()
            return _prepared(request)
        print(process, file=answers, flush=True)
        print(os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]), file=answers, flush=True)
    raise SystemExit


def _prepare_numba() -> None:
    """Have Numba read its tables of functions and types, which it does when a process first compiles or loads code."""
    target = import_module("numba.core.registry").cpu_target
    target.typing_context.refresh()
    target.target_context.refresh()


def _prepared(request: dict[str, Any]) -> list[str]:
    """Make this process that of a command; return the command."""
    os.chdir(request["cwd"])
    os.environ.clear()
    os.environ.update(request["env"])
    for name, descriptor in (("out", 1), ("err", 2)):
        os.dup2(os.open(request[name], os.O_WRONLY | os.O_CREAT), descriptor)
    tempfile.tempdir = None
    added = filter(None, request["env"].get("PYTHONPATH", "").split(os.pathsep))
    command: list[str] = request["command"]
    sys.path[:0] = [str(Path(command[0]).parent), *added]
    return command


def _run(command: list[str]) -> int:
    """Run a command as the interpreter does, up to its exit handlers; return the exit status."""
    sys.argv = command
    status: object = None
    try:
        runpy.run_path(command[0], run_name="__main__")
    except SystemExit as error:
        status = error.code
    except BaseException:
        sys.excepthook(*sys.exc_info())
        status = 1
    threading._shutdown()  # waits for threads
    atexit._run_exitfuncs()
    if status is not None and not isinstance(status, int):
        print(status, file=sys.stderr)
        status = 1
    sys.stdout.flush()
    sys.stderr.flush()
    return status or 0


if __name__ == "__main__":
    # Unloading the libraries would take longer than importing them.
    os._exit(_run(_serve()))
