"""The tracker process, as the command that starts it sees it: its priority, its messages, its end."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from time import monotonic
from typing import Literal

#: Priority of the tracker process: lowest while this process learns, normal while it waits for delivery.
Priority = Literal["background", "foreground"]
BACKGROUND: Priority = "background"
FOREGROUND: Priority = "foreground"


class TrackerProcess:
    """A running tracker process, see `process.main` for what it is sent and what it answers.

    Args:
        folder: of the spool that it delivers.
        priority: to start with.
        log: file that its standard error is appended to.

    Attributes:
        problem: what is wrong with the store; empty if nothing is, None if it is not known yet.
        unusable: why the store cannot be used, after which the process has given up; empty if it can.
    """

    def __init__(self, folder: Path, priority: Priority, log: Path) -> None:
        self.problem: str | None = None
        self.unusable = ""
        self._first_priority = self._priority = priority
        self._since = monotonic()
        with log.open("ab") as errors:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "rl_design_space.tracking.process", str(folder), priority],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
            )
        assert self._process.stdin
        assert self._process.stdout
        self._input, self._output = self._process.stdin, self._process.stdout
        os.set_blocking(self._output.fileno(), False)

    @property
    def is_alive(self) -> bool:
        """Whether the process has not ended yet."""
        return self._process.poll() is None

    def set_priority(self, priority: Priority) -> None:
        """Change the priority of the process if it is another one."""
        if self._priority != priority:
            self._priority, self._since = priority, monotonic()
            with suppress(OSError, ValueError):  # it has died
                self._input.write(f"{priority}\n".encode())
                self._input.flush()

    def is_starved(self, opening_timeout: float) -> bool:
        """Return whether the process should be replaced, because other programs keep it from opening the store.

        It was started in the background, and has not opened the store for so many seconds in the foreground: the import
        of MLflow still runs at the low priority, which cannot be raised again.
        """
        if self.problem is not None or self._first_priority == FOREGROUND or self._priority == BACKGROUND:
            return False
        return monotonic() - self._since > opening_timeout

    def read_messages(self) -> None:
        """Update `problem` and `unusable` from what the process has sent, without waiting."""
        for line in self._output:
            with suppress(ValueError):  # of half a line
                message = json.loads(line)
                if "problem" in message:
                    self.problem = message["problem"] or ""
                self.unusable = message.get("unusable", self.unusable)

    def end(self, grace: float) -> None:
        """End the process; kill it if its current record takes longer than so many seconds."""
        with suppress(OSError):
            self._input.close()
        try:
            self._process.wait(grace)
        except subprocess.TimeoutExpired:
            # The store blocks it. The record that it has begun is continued by the next process.
            self._process.kill()
            self._process.wait()
        self._output.close()
