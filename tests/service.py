"""A program in the background that answers at a port, and that ends with the tests, however they end."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from random import SystemRandom
from time import monotonic, sleep
from typing import Self

#: Below the ports that a system hands to outgoing connections, so that none of these takes that of a stopped service.
_PORTS = range(20_000, 30_000)
#: Seconds that a service may take to answer, and to end.
_START, _END = 90, 20


def free_port() -> int:
    """A port of 127.0.0.1 that nothing listens at."""
    for port in SystemRandom().sample(_PORTS, 100):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            return port
    raise OSError(f"no free port among 100 of {_PORTS}")


@dataclass(kw_only=True)
class Service:
    """A program that can be stopped, killed, and started again at the same port.

    Attributes:
        command: that runs it in the foreground.
        ready: whether it answers.
        port: where it listens, on 127.0.0.1.
        log: file that takes what it writes.
        environment: variables; None for those of the tests.
        user: name of the user that it runs as; None for the one who runs the tests.
        ending: signal that ends it in good order.
    """

    command: Sequence[str]
    ready: Callable[[], bool]
    port: int
    log: Path
    environment: Mapping[str, str] | None = None
    user: str | None = None
    ending: signal.Signals = signal.SIGTERM
    _process: subprocess.Popen[bytes] | None = field(default=None, init=False, repr=False)
    _guard: subprocess.Popen[bytes] | None = field(default=None, init=False, repr=False)

    @property
    def running(self) -> bool:
        """Whether it was started and has not ended."""
        return self._process is not None and self._process.poll() is None

    def start(self) -> None:
        """Run it and wait until it answers.

        Raises:
            RuntimeError: it ended, or did not answer in time; with the end of its log.
        """
        if self.running:
            raise RuntimeError("it runs already")
        with self.log.open("ab") as log:
            self._process = subprocess.Popen(
                self.command,
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                start_new_session=True,
                user=self.user,
                extra_groups=None if self.user is None else [],
            )
        try:
            self._guard = _guard(self._process.pid, self.ending)
            self._wait()
        except BaseException:
            self.kill()
            raise

    def stop(self) -> None:
        """End it in good order; by force if that takes too long."""
        if self._process is not None:
            self._process.send_signal(self.ending)
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(_END)
            self.kill()

    def kill(self) -> None:
        """End it, and all that it started, by SIGKILL."""
        if self._process is None:
            return
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait(_END)
        self._process = None
        if self._guard is not None:
            self._guard.kill()
            self._guard.communicate(timeout=_END)
            self._guard = None
        deadline = monotonic() + _END
        while _listens(self.port):
            if monotonic() > deadline:
                raise RuntimeError(f"something still listens at port {self.port}")
            sleep(0.01)

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def _wait(self) -> None:
        deadline = monotonic() + _START
        while not self.ready():
            if not self.running or monotonic() > deadline:
                end = self.log.read_text(encoding="utf-8", errors="replace")[-4000:]
                raise RuntimeError(f"{' '.join(self.command)} {'is silent' if self.running else 'ended'}:\n{end}")
            sleep(0.05)


def _listens(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def _guard(group: int, ending: signal.Signals) -> subprocess.Popen[bytes]:
    """Watch over a process group from outside: if the tests are killed, the pipe closes, and the group is ended."""
    script = 'read -r _; kill -s "$1" -- "-$2"'
    name = ending.name.removeprefix("SIG")
    return subprocess.Popen(
        ["sh", "-c", script, "guard", name, str(group)],
        stdin=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
