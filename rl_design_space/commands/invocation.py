"""The command that is running: its command line and its exit status."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from rl_design_space.commands.command_line import CommandLine


@dataclass
class Invocation:
    """One call of `rl-design-space`.

    Hydra calls sweepers, launchers and jobs without a way to pass them arguments or to return a status, so they use
    `current_invocation`.

    Attributes:
        line: the command line; None in a process that a launcher of Hydra's has started.
        jobs: number of Hydra jobs that have started in this process.
        failed: whether the exit status is 1, because a point failed or records are pending.
    """

    line: CommandLine | None = None
    jobs: int = 0
    failed: bool = False

    def command_or(self, default: str = "rl-design-space") -> str:
        """Return the command line as text, or `default` if it is not known."""
        return self.line.command if self.line else default


_current: ContextVar[Invocation] = ContextVar("invocation")


@contextmanager
def running(invocation: Invocation) -> Iterator[Invocation]:
    """Make an invocation the current one."""
    token = _current.set(invocation)
    try:
        yield invocation
    finally:
        _current.reset(token)


def current_invocation() -> Invocation:
    """Return the current invocation; a new one in a process that a launcher of Hydra's has started."""
    return _current.get(None) or Invocation()
