"""Locks on points: one process holds a lock at a time, and a process that ends leaves none behind."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.locks import PointLocks, locks_at, locks_path
from tests.command_runner import PATIENCE, finished, heed_interrupts, next_line

#: Locks the names among its arguments, prints whether it could, then calls the methods that its input names.
OTHER = """
import sys
from pathlib import Path
from rl_design_space.tracking.locks import PointLocks

locks = PointLocks(Path(sys.argv[1]))
print(*(locks.acquire(name) for name in sys.argv[2:]), flush=True)
for line in sys.stdin:
    word, name = line.split()
    print(getattr(locks, word)(name), flush=True)
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "new" / "store.claims"


class Other:
    """Another process."""

    def __init__(self, path: Path, *names: str) -> None:
        command = [sys.executable, "-c", OTHER, str(path), *names]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True, preexec_fn=heed_interrupts)
        self.locked = next_line(self.process).split()

    def call(self, word: str, name: str) -> str:
        self.process.stdin.write(f"{word} {name}\n")
        self.process.stdin.flush()
        return next_line(self.process).strip()


@pytest.fixture
def other(path: Path) -> Iterator:
    started: list[Other] = []

    def start(*names: str) -> Other:
        started.append(Other(path, *names))
        return started[-1]

    yield start
    for one in started:
        one.process.kill()
        finished(one.process)


def test_a_lock_belongs_to_one_process(path: Path, other):
    locks = PointLocks(path)
    assert locks.acquire("a")
    them = other("a", "b")
    assert them.locked == ["False", "True"]
    assert not locks.acquire("b")
    assert locks.acquire("c")


def test_a_process_cannot_acquire_a_lock_twice(path: Path):
    locks = PointLocks(path)
    assert [locks.acquire("a"), locks.acquire("a")] == [True, False]
    locks.release("a")
    assert locks.acquire("a")


def test_a_released_lock_can_be_acquired(path: Path, other):
    locks = PointLocks(path)
    them = other("a")
    assert not locks.acquire("a")
    them.call("release", "a")
    assert locks.acquire("a")


def test_a_lock_of_another_process_cannot_be_released(path: Path, other):
    locks = PointLocks(path)
    other("a")
    locks.release("a")
    assert not locks.acquire("a")


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_locks_end_with_their_process(path: Path, other, how: signal.Signals):
    locks = PointLocks(path)
    them = other("a", "b")
    assert not locks.acquire("a")
    them.process.send_signal(how)
    them.process.wait(PATIENCE)
    assert locks.acquire("a")
    assert locks.acquire("b")


def test_a_file_system_without_locks_is_reported(path: Path, monkeypatch: pytest.MonkeyPatch):
    def fail(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    locks = PointLocks(path)
    monkeypatch.setattr("fcntl.lockf", fail)
    with pytest.raises(ConfigError, match=r"store\.claims: files cannot be locked here \(No locks available\); keep"):
        locks.acquire("a")


def test_the_journal_shows_what_other_processes_record(path: Path, other):
    locks, them = PointLocks(path), other()
    one, two = "1" * 64, "2" * 64
    them.call("add_to_journal", one)
    assert locks.in_journal(one)
    assert not locks.in_journal(two)
    them.call("add_to_journal", two)
    assert locks.in_journal(two)
    locks.skip_journal()
    assert not locks.in_journal(one)
    # The journal itself is kept.
    assert path.read_text().split() == [one, two]


def test_a_journal_of_any_length_is_read(path: Path):
    locks, writer = PointLocks(path), PointLocks(path)
    names = [f"{number:064}" for number in range(3000)]
    for name in names:
        writer.add_to_journal(name)
    assert all(locks.in_journal(name) for name in names)


def test_a_process_has_one_object_for_each_file(path: Path):
    assert locks_at(path) is locks_at(path)
    assert locks_at(path) is not locks_at(path.with_name("other.claims"))


def test_locks_of_a_server_are_where_all_processes_of_the_user_find_them(tmp_path: Path):
    one, same, other = (locks_path(uri, tmp_path) for uri in ("http://a:5000", "http://a:5000", "http://b:5000"))
    assert one == same != other
    assert one.is_relative_to(tmp_path)
    assert locks_path(f"sqlite:///{tmp_path}/x.db") == tmp_path / "x.db.claims"
    assert one.parent.stat().st_mode & 0o777 == 0o700


def test_a_folder_for_locks_of_an_earlier_version_is_closed_to_others(tmp_path: Path):
    earlier = tmp_path / f"rl-design-space-{os.getuid()}"
    earlier.mkdir(mode=0o755)
    assert locks_path("http://a:5000", tmp_path).parent == earlier
    assert earlier.stat().st_mode & 0o777 == 0o700


def test_a_folder_for_locks_that_is_another_users_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    locks_path("http://a:5000", tmp_path)
    us = os.getuid()
    (tmp_path / f"rl-design-space-{us + 1}").mkdir()
    monkeypatch.setattr("os.getuid", lambda: us + 1)
    with pytest.raises(ConfigError, match=r"rl-design-space-\d+: belongs to .*; locks of a tracking server are"):
        locks_path("http://a:5000", tmp_path)


@pytest.mark.parametrize("obstacle", ["link", "dangling link", "file"])
def test_nothing_but_a_folder_is_used_for_locks(obstacle: str, tmp_path: Path):
    folder = tmp_path / f"rl-design-space-{os.getuid()}"
    if obstacle == "file":
        folder.write_text("")
    else:
        folder.symlink_to(tmp_path / "nowhere" if "dangling" in obstacle else tmp_path)
    with pytest.raises(ConfigError, match=r"TMPDIR"):
        locks_path("http://a:5000", tmp_path)


def test_a_link_is_not_followed(path: Path):
    path.parent.mkdir()
    (path.parent / "precious").write_text("mine")
    path.symlink_to("precious")
    with pytest.raises(ConfigError, match=r"store\.claims: is a link, which is not followed; remove it"):
        PointLocks(path)
    assert (path.parent / "precious").read_text() == "mine"


def test_something_else_than_a_file_is_refused(path: Path):
    path.parent.mkdir()
    os.mkfifo(path)
    with pytest.raises(ConfigError, match=r"store\.claims: is not a regular file"):
        PointLocks(path)
    path.unlink()
    path.mkdir()
    with pytest.raises(ConfigError, match=r"store\.claims: cannot be opened for locking \(Is a directory, it bel"):
        PointLocks(path)
