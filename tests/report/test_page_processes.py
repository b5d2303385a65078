"""The processes that write the reports of a page."""

from __future__ import annotations

import os
import signal
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Semaphore
from typing import Any

import pytest

from rl_design_space.report import beside, page
from rl_design_space.tracking.reader import NoRuns


@dataclass(frozen=True)
class Part:
    """As much of a study as the page needs."""

    name: str
    plan: tuple[int, ...]
    included: tuple[Part, ...] = ()
    planner: None = None

    def report(self) -> None:
        """Import what writes the report."""


PARTS = [Part("small", (1,)), Part("large", (1, 2, 3), (Part("inner", ()),)), Part("none", ()), Part("middle", (1, 2))]


@pytest.fixture
def pools(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, str]]:
    """Pools of threads in place of processes; number of workers and way to start them of each."""
    made: list[tuple[int, str]] = []

    def pool(workers: int, method: Any) -> ThreadPoolExecutor:
        made.append((workers, method))
        return ThreadPoolExecutor(1)

    monkeypatch.setattr(page, "ProcessPoolExecutor", pool)
    monkeypatch.setattr(page, "get_context", str)
    return made


@pytest.fixture
def written(monkeypatch: pytest.MonkeyPatch) -> list[Part]:
    """The parts in the order in which they are written."""
    parts: list[Part] = []

    def write(part: Part, reader: object, folder: Path, look: object) -> list[Path]:
        parts.append(part)
        return [folder / part.name]

    monkeypatch.setattr(page, "_write", write)
    return parts


def write_all(cores: int, threads: int, parts: list[Part], monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.setattr(page, "available_threads", lambda: cores)
    monkeypatch.setattr(beside.sys, "platform", "linux")
    monkeypatch.setattr(beside.threading, "active_count", lambda: threads)
    return [path.name for paths in page._write_all(parts, NoRuns(), Path()) for path in paths]


@pytest.mark.parametrize(("threads", "method"), [(1, "fork"), (2, "spawn")])
def test_processes_are_copies_unless_another_thread_may_hold_a_lock(
    threads: int, method: str, pools: list[tuple[int, str]], written: list[Part], monkeypatch: pytest.MonkeyPatch
):
    imported: list[str] = []
    monkeypatch.setattr(Part, "report", lambda part: imported.append(part.name))
    names = write_all(3, threads, PARTS, monkeypatch)
    assert pools == [(3, method)]
    assert imported == (names if method == "fork" else [])  # once, before the copies are made
    assert names == [part.name for part in PARTS]
    assert [part.name for part in written] == ["none", "large", "middle", "small"]
    assert not any(part.included for part in written)  # which would be copied for nothing


@pytest.mark.parametrize(("cores", "parts"), [(1, PARTS), (8, PARTS[:3])])
def test_few_reports_or_cores_need_no_processes(
    cores: int, parts: list[Part], pools: list[tuple[int, str]], written: list[Part], monkeypatch: pytest.MonkeyPatch
):
    assert write_all(cores, 1, parts, monkeypatch) == [part.name for part in parts]
    assert written == parts
    assert pools == []


def test_an_interrupt_begins_no_more_reports(
    pools: list[tuple[int, str]], written: list[Part], monkeypatch: pytest.MonkeyPatch
):
    submitted, ended = Semaphore(0), Event()

    class Pool(ThreadPoolExecutor):
        def submit(self, *arguments: Any) -> Any:
            future = super().submit(*arguments)
            submitted.release()
            return future

        def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
            super().shutdown(wait=False, cancel_futures=cancel_futures)
            ended.set()
            super().shutdown(wait=wait)

    def interrupted(part: Part, *_: object) -> list[Path]:
        written.append(part)
        if len(written) == 1:
            assert all(submitted.acquire(timeout=10) for _ in PARTS)
            os.kill(os.getpid(), signal.SIGINT)
            ended.wait(10)
        return []

    monkeypatch.setattr(page, "ProcessPoolExecutor", lambda workers, method: Pool(1))
    monkeypatch.setattr(page, "_write", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_all(3, 1, PARTS, monkeypatch)
    assert len(written) == 1
