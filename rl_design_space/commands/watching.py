"""Progress of a report, and its main numbers, on stderr: stdout has the paths of the files."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from time import monotonic
from typing import TypeVar

from rl_design_space.commands.messages import tell

Item = TypeVar("Item")

#: Seconds after which a bar appears.
_PATIENCE = 1.0


def tell_all(lines: Sequence[str]) -> None:
    """Print lines to stderr."""
    for line in lines:
        tell(line)


def watched(items: Sequence[Item], what: str) -> Iterable[Item]:
    """Yield items; in a terminal, show a bar if they take longer than a second."""
    begun, bar, task = monotonic(), None, None
    try:
        for number, item in enumerate(items):
            if bar is None and sys.stderr.isatty() and monotonic() - begun > _PATIENCE:
                from rich.console import Console
                from rich.progress import Progress

                bar = Progress(console=Console(stderr=True), transient=True)
                task = bar.add_task(what, total=len(items))
                bar.start()
            if bar is not None and task is not None:
                bar.update(task, completed=number)
            yield item
    finally:
        if bar is not None:
            bar.stop()
