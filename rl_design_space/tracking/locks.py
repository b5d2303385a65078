"""Which design points are being learned at the moment, among all processes that record into one store."""

from __future__ import annotations

import fcntl
import hashlib
import os
from functools import cache
from pathlib import Path
from tempfile import gettempdir

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.address import sqlite_path

#: A digest in hexadecimal digits, and the end of its line.
_LINE = 65


class Claims:
    """Points that processes of this machine have taken upon themselves, and those that they have recorded.

    A claim is a lock on one byte of a file, at a place that follows from the point's fingerprint. The system lets go of
    it when the process ends, however it ends: no claim is ever left behind. The file's content is a journal, to which
    each process adds the fingerprint of a point right before its run counts as finished.

    Claims are a process's; one object a file and process is enough, see `claims_at`.
    """

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._path = path
        self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        self._mine: set[str] = set()
        self._read = 0
        self._recorded: set[str] = set()
        self.forget()

    def take(self, name: str) -> bool:
        """Claim a name; False if anybody has it, this process included.

        Raises:
            ConfigError: the file lies where there are no locks, as on some network file systems.
        """
        if name in self._mine:
            return False
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, _place(name))
        except (BlockingIOError, PermissionError):  # which of them depends on the system
            return False
        except OSError as error:
            raise ConfigError(
                f"{self._path}: files cannot be locked here ({error.strerror}); keep the store on a local disk, "
                "or use a tracking server"
            ) from error
        self._mine.add(name)
        return True

    def release(self, name: str) -> None:
        """Give up a claim."""
        if name in self._mine:
            self._mine.remove(name)
            fcntl.lockf(self._file, fcntl.LOCK_UN, 1, _place(name))

    def announce(self, fingerprint: str) -> None:
        """Note in the journal that a point's run is about to be finished."""
        os.write(self._file, f"{fingerprint}\n".encode())

    def announced(self, fingerprint: str) -> bool:
        """Whether any process has noted this point since `forget` was called."""
        while lines := os.pread(self._file, _LINE * 1024, self._read):
            self._read += len(lines)
            self._recorded.update(lines.decode().split())
        return fingerprint in self._recorded

    def forget(self) -> None:
        """Begin to watch the journal from here."""
        self._read = os.fstat(self._file).st_size
        self._recorded.clear()


def claims_path(uri: str) -> Path:
    """Beside a SQLite database; for other stores, where all processes of the user on this machine find it."""
    if database := sqlite_path(uri):
        return database.with_name(f"{database.name}.claims")
    store = hashlib.sha256(uri.encode()).hexdigest()[:16]
    return Path(gettempdir()) / f"rl-design-space-{os.getuid()}" / f"{store}.claims"


@cache
def claims_at(path: Path) -> Claims:
    """The claims of this process in a file: closing a second descriptor of the file would give them up."""
    return Claims(path)


def _place(name: str) -> int:
    """Where in the file the lock lies: 62 bits, so that two names meet once in 10^18."""
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:8]) >> 2
