"""The main numbers of reports on stderr: stdout has the paths of the files."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rl_design_space.commands.messages import tell

if TYPE_CHECKING:
    from rich.table import Table

    from rl_design_space.report.written import MainNumbers

#: Reports, and sentences and rows of each, that are printed at most.
_REPORTS, _LINES = 8, 20
#: Width where the output is no terminal: nothing is folded.
_UNBOUNDED = 10_000


def tell_numbers(reports: Sequence[MainNumbers]) -> None:
    """Print the main numbers of reports; of many reports, those of the first."""
    for numbers in reports[:_REPORTS]:
        _tell(numbers)
    if more := len(reports[_REPORTS:]):
        tell(f"and {more} more reports; their numbers are in the files")


def _tell(numbers: MainNumbers) -> None:
    tell(numbers.heading)
    for line in numbers.lines[:_LINES]:
        tell(f"  {line}")
    if numbers.rows:
        from rl_design_space.commands.terminal import Terminal

        width = None if sys.stderr.isatty() else _UNBOUNDED
        Terminal(stderr=True, highlight=False, width=width).print(_table(numbers))
    if more := max(len(numbers.lines[_LINES:]), len(numbers.rows[_LINES:])):
        tell(f"  and {more:,} more rows, in the files")


def _table(numbers: MainNumbers) -> Table:
    """Return the first rows; columns of numbers are aligned on the right, as in Markdown."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    from rl_design_space.report.markdown import alignment, unmarked

    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    columns = list(zip(*numbers.rows, strict=True))
    for name, cells in zip(numbers.header, columns, strict=True):
        table.add_column(Text(unmarked(name)), justify=alignment(list(cells)), overflow="fold")
    for row in numbers.rows[:_LINES]:
        table.add_row(*(Text(unmarked(cell)) for cell in row))
    return table
