"""The server of the UI ends with the command that has started it, however that ends."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.command_runner import next_line, wait_until

#: A command that starts a guard, and a server that prints the process ids of its child and of itself.
COMMAND = """
import subprocess, sys
from rl_design_space.tracking import ui_guard
server = ["sh", "-c", "sleep 600 & echo $! $$; wait"]
guard = [sys.executable, "-P", ui_guard.__file__, *server]
process = subprocess.Popen(guard, stdin=subprocess.PIPE, start_new_session=True)
process.wait(600)
"""


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGHUP])
def test_a_server_ends_with_its_command(how: signal.Signals):
    command = subprocess.Popen([sys.executable, "-c", COMMAND], stdout=subprocess.PIPE, text=True)
    server = [Path(f"/proc/{number}") for number in next_line(command).split()]
    assert len(server) == 2
    assert all(process.exists() for process in server)
    command.send_signal(how)
    command.communicate(timeout=60)
    wait_until(lambda: not any(map(_lives, server)), seconds=30)


def _lives(process: Path) -> bool:
    try:
        return (process / "stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False
