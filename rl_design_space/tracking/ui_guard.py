"""The process between the UI command and MLflow's server: the server ends when the command does, however it ends.

It holds the reading end of a pipe from the command; the operating system closes the other end with the command.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import suppress
from threading import Thread

#: Seconds that the server has to end before it is killed.
GRACE = 10


def main() -> None:
    """Run the command that the arguments name, and end it and all its children when standard input ends."""
    # Ctrl-C and signals to the group are for the command and the server.
    for ignored in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(ignored, signal.SIG_IGN)
    server = subprocess.Popen(sys.argv[1:], stdin=subprocess.DEVNULL, preexec_fn=_heed_signals)
    Thread(target=_watch_input, args=(server,), daemon=True).start()
    server.wait()
    # Its children, if it did not end them, and this process.
    os.killpg(0, signal.SIGKILL)


def _heed_signals() -> None:
    for heeded in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(heeded, signal.SIG_DFL)


def _watch_input(server: subprocess.Popen[bytes]) -> None:
    sys.stdin.buffer.read()
    os.killpg(0, signal.SIGTERM)
    with suppress(subprocess.TimeoutExpired):
        server.wait(GRACE)
    os.killpg(0, signal.SIGKILL)


if __name__ == "__main__":
    main()
