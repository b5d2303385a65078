"""Run the UI command in the background."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.command_runner import started

#: Text in the last line that the command prints.
LAST = "all sweeps"


@contextmanager
def ui_of(folder: Path, outputs: str) -> Iterator[dict[str, str]]:
    """Run `rl-design-space ui` in a folder, and end it.

    Yields:
        The addresses that it names, by what they are links to.
    """
    port = free_port()
    command = started(folder, "ui", f"outputs={outputs}", "--port", str(port))
    try:
        yield _links(command)
    finally:
        command.send_signal(signal.SIGTERM)
        _, errors = command.communicate(timeout=30)
    assert (command.returncode, errors) == (0, "")
    assert _processes_about(port) == []


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def _links(command: subprocess.Popen[str]) -> dict[str, str]:
    assert command.stdout is not None
    links: dict[str, str] = {}
    while LAST not in links:
        line = command.stdout.readline()
        if not line:
            raise RuntimeError(f"the command has ended: {command.communicate()}")
        what, *address = re.split(r"\s{2,}|: |; ", line.strip())
        links[what] = address[0]
    return links


def _processes_about(port: int) -> list[str]:
    listed = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True, check=True).stdout
    return [line for line in listed.splitlines() if re.search(rf"--port[ =]{port}\b", line)]
