"""The command that is running: what was typed, and what came of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from rl_design_space.commands.command_line import CommandLine


@dataclass
class Invocation:
    """One call of `rl-design-space`.

    Hydra calls plugins and jobs without a way to pass arguments or return a status: they ask for it with
    `current_invocation`.

    Attributes:
        line: what was typed.
        jobs: jobs that Hydra's sweepers have run; they take a sweep that matches nothing for a success.
        undelivered: whether results are still to be delivered to the tracking store.
    """

    line: CommandLine | None = None
    jobs: int = 0
    undelivered: bool = False

    def command_or(self, other: str) -> str:
        """Return the command that was typed; `other` in a process that another one has started."""
        return self.line.command if self.line else other


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
    """Return the invocation that is running; a new one in a process that a launcher of Hydra's has started."""
    return _current.get(None) or Invocation()
