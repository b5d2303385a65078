"""Work in a copy of this process: where there is one, and how errors come back."""

from __future__ import annotations

import os
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

from rl_design_space.report import beside as module
from rl_design_space.report.beside import beside
from rl_design_space.report.style import save

HERE = os.getpid()


@pytest.fixture
def copied(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two cores, and no other thread that might hold a lock."""
    monkeypatch.setattr(module, "available_threads", lambda: 2)
    monkeypatch.setattr(module, "parent_process", lambda: None)
    monkeypatch.setattr(module, "can_be_copied", lambda: True)


@pytest.mark.usefixtures("copied")
def test_work_is_done_in_a_copy_that_needs_no_arguments():
    unsent = {"not": (each for each in "pickled")}
    assert beside(lambda: os.getpid() if "not" in unsent else None)() != HERE


@pytest.mark.usefixtures("copied")
def test_what_a_copy_cannot_do_is_done_here():
    def dies_in_a_copy() -> int:
        if os.getpid() != HERE:
            os._exit(1)
        return os.getpid()

    def fails() -> None:
        raise LookupError("no such point")

    assert beside(dies_in_a_copy)() == HERE
    assert beside(lambda: (os.getpid(), lambda: None))()[0] == HERE  # a function cannot be sent
    result = beside(fails)
    with pytest.raises(LookupError, match="no such point"):
        result()


@pytest.mark.usefixtures("copied")
@pytest.mark.parametrize(
    ("name", "value"), [("available_threads", 1), ("parent_process", "the page's"), ("can_be_copied", False)]
)
def test_there_is_no_copy_without_a_core_or_beside_other_threads(
    name: str, value: object, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(module, name, lambda: value)
    assert beside(os.getpid)() == HERE


@pytest.mark.usefixtures("copied")
def test_pictures_are_the_same_whether_a_copy_draws_them_or_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def written(name: str) -> list[bytes]:
        figure, axis = plt.subplots(figsize=(2, 1), layout="constrained")
        axis.set(title="title", xlabel="label")
        return [path.read_bytes() for path in save(figure, tmp_path / name)]

    by_copy = written("copy")
    monkeypatch.setattr(module, "can_be_copied", lambda: False)
    assert written("alone") == by_copy
