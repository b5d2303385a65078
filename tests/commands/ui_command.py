"""Run the UI command in the background."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.command_runner import finished, next_line, output_of, started

#: Text in the last line that the command prints.
LAST = "all sweeps"


@contextmanager
def ui_of(folder: Path, outputs: str) -> Iterator[dict[str, str]]:
    """Run `rl-design-space ui` in a folder, and end it.

    Yields:
        The addresses that it names, by what they are links to.
    """
    port = free_port()
    with started(folder, "ui", f"outputs={outputs}", "--port", str(port)) as command:
        try:
            yield _links(command)
        finally:
            command.send_signal(signal.SIGTERM)
            done = finished(command)
    assert (done.returncode, done.stderr) == (0, "")
    assert _processes_about(port) == []


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def _links(command: subprocess.Popen[str]) -> dict[str, str]:
    links: dict[str, str] = {}
    while LAST not in links:
        line = next_line(command)
        if not line:
            raise RuntimeError(f"the command has ended: {finished(command)}")
        what, *address = re.split(r"\s{2,}|: |; ", line.strip())
        links[what] = address[0]
    return links


def _processes_about(port: int) -> list[str]:
    return [line for line in output_of("ps", "-eo", "args").splitlines() if re.search(rf"--port[ =]{port}\b", line)]
