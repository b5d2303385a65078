"""Claims: one process has a point at a time, and none is left behind by a process that has gone."""

from __future__ import annotations

import errno
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.locks import Claims, claims_at
from tests.command_runner import PATIENCE, finished, heed_interrupts, next_line

#: Takes what it is told, says whether it could, and waits to be ended.
OTHER = """
import sys
from pathlib import Path
from rl_design_space.tracking.locks import Claims

claims = Claims(Path(sys.argv[1]))
print(*(claims.take(name) for name in sys.argv[2:]), flush=True)
for line in sys.stdin:
    word, name = line.split()
    print(getattr(claims, word)(name), flush=True)
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
        self.took = next_line(self.process).split()

    def does(self, word: str, name: str) -> str:
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


def test_a_claim_is_of_one_process(path: Path, other):
    claims = Claims(path)
    assert claims.take("a")
    them = other("a", "b")
    assert them.took == ["False", "True"]
    assert not claims.take("b")
    assert claims.take("c")


def test_a_process_has_a_claim_once(path: Path):
    claims = Claims(path)
    assert [claims.take("a"), claims.take("a")] == [True, False]
    claims.release("a")
    assert claims.take("a")


def test_a_claim_that_is_released_can_be_taken(path: Path, other):
    claims = Claims(path)
    them = other("a")
    assert not claims.take("a")
    them.does("release", "a")
    assert claims.take("a")


def test_what_one_never_had_is_not_given_up(path: Path, other):
    claims = Claims(path)
    other("a")
    claims.release("a")
    assert not claims.take("a")


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_claims_end_with_their_process(path: Path, other, how: signal.Signals):
    claims = Claims(path)
    them = other("a", "b")
    assert not claims.take("a")
    them.process.send_signal(how)
    them.process.wait(PATIENCE)
    assert claims.take("a")
    assert claims.take("b")


def test_a_file_system_without_locks_is_told(path: Path, monkeypatch: pytest.MonkeyPatch):
    def fail(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    claims = Claims(path)
    monkeypatch.setattr("fcntl.lockf", fail)
    with pytest.raises(ConfigError, match=r"store\.claims: files cannot be locked here \(No locks available\); keep"):
        claims.take("a")


def test_what_others_record_is_known(path: Path, other):
    claims, them = Claims(path), other()
    one, two = "1" * 64, "2" * 64
    them.does("announce", one)
    assert claims.announced(one)
    assert not claims.announced(two)
    them.does("announce", two)
    assert claims.announced(two)
    claims.forget()
    assert not claims.announced(one)
    # It was written down all the same, for those who come later to be found in the store.
    assert path.read_text().split() == [one, two]


def test_a_journal_of_any_length_is_read(path: Path):
    claims, writer = Claims(path), Claims(path)
    names = [f"{number:064}" for number in range(3000)]
    for name in names:
        writer.announce(name)
    assert all(claims.announced(name) for name in names)


def test_a_process_has_one_object_for_a_file(path: Path):
    assert claims_at(path) is claims_at(path)
    assert claims_at(path) is not claims_at(path.with_name("other.claims"))
