"""A reader that has looked up the points of a study."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rl_design_space.tracking.reader import FoundRuns
from rl_design_space.tracking.tracker import StoredRun


class Counting:
    """A reader of the points a and c that counts how often it is asked."""

    in_flight = 6

    def __init__(self) -> None:
        self.asked: list[set[str]] = []
        self.attached: list[tuple[str, Sequence[Path]]] = []

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        self.asked.append(set(fingerprints))
        return {each: StoredRun(f"run of {each}") for each in fingerprints if each in "ac"}

    def periods(self, run: StoredRun) -> dict[str, Any]:
        return {"steps": np.array([len(run.run_id)])}

    def link(self, ui: str, study: str) -> str:
        return f"{ui}/{study}"

    def attach(self, study: str, paths: Sequence[Path]) -> None:
        self.attached.append((study, paths))


def test_points_are_looked_up_once():
    reader = Counting()
    found = FoundRuns(reader, ["a", "b", "c"])
    assert found.finished(["c", "b"]) == {"c": StoredRun("run of c")}
    assert list(found.finished(["c", "a"])) == ["c", "a"]
    assert found.finished([]) == {}
    assert reader.asked == [{"a", "b", "c"}]


def test_points_of_other_studies_are_looked_up_when_they_are_asked_for():
    reader = Counting()
    found = FoundRuns(reader, ["a"])
    assert found.finished(["a", "c", "d"]) == {"a": StoredRun("run of a"), "c": StoredRun("run of c")}
    assert reader.asked == [{"a"}, {"a", "c", "d"}]


def test_everything_else_is_asked_of_the_reader():
    reader = Counting()
    found = FoundRuns(reader, ["a"])
    assert found.periods(StoredRun("four"))["steps"].tolist() == [4]
    assert found.in_flight == 6
    assert found.link("ui", "fig2") == "ui/fig2"
    found.attach("fig2", [Path("fig2.png")])
    assert reader.attached == [("fig2", [Path("fig2.png")])]
