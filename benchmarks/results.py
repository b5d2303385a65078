"""Where results go: the terminal, and three files a part."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from benchmarks.machine import facts, load_average
from benchmarks.tables import page, show


class Results:
    """The results of one part of the benchmarks. Made before anything is measured, to see the load before and after.

    Args:
        folder: is created if need be.
        name: of the files: `name.csv` with all numbers, `name_calls.csv` with every single call, and `name.md` with
            the table that people read and the facts about machine and versions.
        title: of the table.
    """

    def __init__(self, folder: Path, name: str, title: str) -> None:
        self._folder, self._name, self._title = folder, name, title
        self._folder.mkdir(parents=True, exist_ok=True)
        self._load = load_average()

    def save(
        self, frame: pd.DataFrame, text: pd.DataFrame, calls: pd.DataFrame, notes: Mapping[str, str] | None = None
    ) -> None:
        """Write and print."""
        load = f"{self._load} before, {load_average()} after"
        notes = {**(notes or {}), **facts(), "load average": load}
        frame.to_csv(self._folder / f"{self._name}.csv", index=False)
        calls.to_csv(self._folder / f"{self._name}_calls.csv", index=False)
        text_page = page(self._title, text, notes)
        (self._folder / f"{self._name}.md").write_text(text_page, encoding="utf-8")
        show(text, self._title, notes)
