"""Results as tables: in the terminal, in CSV and in Markdown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

#: Never so narrow that numbers break in two.
console = Console(highlight=False, width=max(120, Console().width))


def number(value: float) -> str:
    """Three digits, as many as a measured time deserves, but no more than three decimals; – for none."""
    if np.isnan(value):
        return "–"
    if not np.isfinite(value) or value == 0:
        return f"{value:.0f}"
    return f"{value:,.{min(3, max(0, 2 - int(np.floor(np.log10(abs(value))))))}f}"


def spread(row: Mapping[Any, Any], middle: str, low: str, high: str) -> str:
    """A median and its quartiles."""
    if number(row[middle]) == "–":
        return "–"
    return f"{number(row[middle])} ({number(row[low])} – {number(row[high])})"


def show(frame: pd.DataFrame, title: str, notes: Mapping[str, str]) -> None:
    """Print a table of text, and the facts behind it."""
    table = Table(title=escape(title), box=SIMPLE_HEAD, title_justify="left", pad_edge=False)
    for position, column in enumerate(frame.columns):
        table.add_column(escape(str(column)), justify="right" if position else "left")
    for row in frame.itertuples(index=False):
        table.add_row(*(escape(str(cell)) for cell in row))
    console.print(table)
    for key, value in notes.items():
        console.print(f"  {escape(key)}: {escape(value)}", style="dim")


def markdown(frame: pd.DataFrame) -> str:
    """A table of text in Markdown."""
    rows = [list(frame.columns), ["---"] * len(frame.columns), *frame.itertuples(index=False, name=None)]
    return "".join(f"| {' | '.join(str(cell).replace('|', '/') for cell in row)} |\n" for row in rows)


def page(title: str, text: pd.DataFrame, notes: Mapping[str, str]) -> str:
    """A table and the facts behind it in Markdown."""
    facts = "".join(f"- {key}: {value}\n" for key, value in notes.items())
    return f"# {title}\n\n{markdown(text)}\n{facts}"
