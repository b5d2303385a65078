"""Progress of a report, and its main numbers, on stderr: stdout has the paths of the files."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import TypeVar

from rl_design_space.commands.messages import tell

Item = TypeVar("Item")

#: Reports, lines and paragraphs that are printed at most.
_REPORTS, _LINES, _PARAGRAPHS = 8, 12, 2
#: Beginnings of what is not about numbers, or printed already: headings, pictures and remarks on the runs.
_NOT_NUMBERS = ("#", "![", "Made by", "**Missing:", "Left out:")
#: Seconds after which a bar appears.
_PATIENCE = 1.0


def tell_all(lines: Sequence[str]) -> None:
    """Print lines to stderr."""
    for line in lines:
        tell(line)


def watched(items: Sequence[Item], what: str) -> Iterable[Item]:
    """Yield items; in a terminal, show a bar if they take longer than a second."""
    with counting(what, len(items)) as count:
        for item in items:
            yield item
            count()


@contextmanager
def counting(what: str, total: int) -> Iterator[Callable[[], None]]:
    """Yield a function that counts steps; in a terminal, a bar shows them if they take longer than a second.

    Args:
        what: is done in each step.
        total: number of steps.
    """
    begun, bar, done = monotonic(), None, 0

    def count() -> None:
        nonlocal bar, done
        done += 1
        if bar is None and sys.stderr.isatty() and monotonic() - begun > _PATIENCE:
            from rich.console import Console
            from rich.progress import Progress

            bar = Progress(console=Console(stderr=True), transient=True)
            bar.add_task(what, total=total)
            bar.start()
        if bar is not None:
            bar.update(bar.task_ids[0], completed=done)

    try:
        yield count
    finally:
        if bar is not None:
            bar.stop()


def main_numbers(text: str) -> list[str]:
    """Return the first table or list of the text of a report as lines, or its first paragraphs if it has none."""
    blocks = [block for block in text.strip().split("\n\n") if not block.startswith(_NOT_NUMBERS)]
    listed = [block for block in blocks if block.startswith(("|", "- "))]
    lines = [line for block in listed[:1] or blocks[:_PARAGRAPHS] for line in block.splitlines()]
    lines = [re.sub(r"\\([^\w\s])", r"\1", line) for line in lines if not re.fullmatch(r"[|:\- ]+", line)]
    more = [f"and {len(lines) - _LINES} more rows, in the files"] if len(lines) > _LINES else []
    return [*lines[:_LINES], *more]


def tell_numbers(paths: Sequence[Path]) -> None:
    """Print the main numbers of reports; nothing if there are many of them, as on a page."""
    texts = [path for path in paths if path.suffix == ".md"]
    for path in texts if len(texts) <= _REPORTS else ():
        tell_all(main_numbers(path.read_text(encoding="utf-8")))
