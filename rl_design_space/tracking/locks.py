"""Locks on design points, shared by all processes that record into one store."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import os
import pwd
import stat
from functools import cache
from pathlib import Path
from tempfile import gettempdir

from rl_design_space._paths import why_unwritable
from rl_design_space.errors import ConfigError
from rl_design_space.tracking.address import sqlite_path
from rl_design_space.tracking.read_only import not_writable

#: Bytes of a line of the journal: a digest in hexadecimal digits, and the end of the line.
_LINE = 65


class PointLocks:
    """Locks on points and sweeps among the processes of this machine, and a journal of recorded points.

    A lock is a POSIX lock on one byte of a file, at an offset that follows from the name. The operating system releases
    it when the process ends, however it ends, so no stale lock is left behind. The content of the file is the journal:
    each process appends the fingerprint of a point right before the run of the point counts as finished.

    Locks belong to the process, and closing any descriptor of the file releases all of them: use one object for each
    file and process, see `locks_at`.

    Args:
        path: the file; it and its folder are created if missing.

    Raises:
        ConfigError: there is something else than a file that this user may write, such as a link.
    """

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._path = path
        self._file = _opened(path)
        self._held: set[str] = set()
        self._journal_offset = 0
        self._recorded: set[str] = set()
        self.skip_journal()

    def acquire(self, name: str) -> bool:
        """Lock a name; return False if it is locked, by this process or another one.

        Raises:
            ConfigError: the file is on a file system without locks, as some network file systems are.
        """
        if name in self._held:
            return False
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, lock_number(name))
        except (BlockingIOError, PermissionError):  # which of them depends on the system
            return False
        except OSError as error:
            raise ConfigError(
                f"{self._path}: files cannot be locked here ({error.strerror}); keep the store on a local disk, "
                "or use a tracking server"
            ) from error
        self._held.add(name)
        return True

    def release(self, name: str) -> None:
        """Release a lock if this process holds it."""
        if name in self._held:
            self._held.remove(name)
            fcntl.lockf(self._file, fcntl.LOCK_UN, 1, lock_number(name))

    def is_free(self, name: str) -> bool:
        """Return whether no process holds the lock of a name."""
        if not self.acquire(name):
            return False
        self.release(name)
        return True

    def add_to_journal(self, fingerprint: str) -> None:
        """Append a point to the journal; call it right before its run is marked as finished."""
        os.write(self._file, f"{fingerprint}\n".encode())

    def in_journal(self, fingerprint: str) -> bool:
        """Return whether any process has added a point to the journal since `skip_journal` was called."""
        while lines := os.pread(self._file, _LINE * 1024, self._journal_offset):
            self._journal_offset += len(lines)
            self._recorded.update(lines.decode().split())
        return fingerprint in self._recorded

    def skip_journal(self) -> None:
        """Ignore what the journal holds so far."""
        self._journal_offset = os.fstat(self._file).st_size
        self._recorded.clear()


def locks_path(uri: str, shared: Path | None = None) -> Path:
    """Return the file that holds the locks of a store.

    Args:
        uri: URI of the store.
        shared: folder for the locks of stores that are no SQLite files; the system's folder of temporary files if None.

    Returns:
        A file beside a SQLite database; for any other store, one in a folder where all processes of the user on this
        machine find it, and which no other user can enter.

    Raises:
        ConfigError: that folder is not this user's, or cannot be created.
    """
    if database := sqlite_path(uri):
        return database.with_name(f"{database.name}.claims")
    store = hashlib.sha256(uri.encode()).hexdigest()[:16]
    return _private(shared or Path(gettempdir())) / f"{store}.claims"


@cache
def locks_at(path: Path) -> PointLocks:
    """Return this process's only `PointLocks` of a file."""
    return PointLocks(path)


def lock_number(name: str) -> int:
    """Return the number of a lock, its offset in the file: 62 bits, so that two names collide once in 10^18."""
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:8]) >> 2


def _private(parent: Path) -> Path:
    """Return this user's own folder in a folder that all users may write to; create it if missing."""
    folder = parent / f"rl-design-space-{os.getuid()}"
    remedy = "locks of a tracking server are kept there; remove it, or set TMPDIR to a folder of your own"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = folder.lstat()
    except OSError as error:
        raise ConfigError(f"{folder}: cannot be used as a folder ({error.strerror}); {remedy}") from error
    if not stat.S_ISDIR(found.st_mode):
        raise ConfigError(f"{folder}: is a link, which is not followed; {remedy}")
    if found.st_uid != os.getuid():
        raise ConfigError(f"{folder}: belongs to {_user(found.st_uid)}; {remedy}")
    if found.st_mode & 0o077:  # created by version 0.1.0
        folder.chmod(0o700)
    return folder


def _opened(path: Path) -> int:
    """Open a file of locks; it must not be a link, which another user may have put there."""
    try:
        file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666)
    except OSError as error:
        if path.is_symlink():
            raise ConfigError(f"{path}: is a link, which is not followed; remove it") from error
        if error.errno == errno.EROFS:
            raise not_writable(path.parent, why_unwritable(path)) from error
        owner = f", it belongs to {_user(path.stat().st_uid)}" if path.exists() else ""
        raise ConfigError(f"{path}: cannot be opened for locking ({error.strerror}{owner})") from error
    if not stat.S_ISREG(os.fstat(file).st_mode):
        os.close(file)
        raise ConfigError(f"{path}: is not a regular file; remove it")
    return file


def _user(number: int) -> str:
    try:
        return f"the user {pwd.getpwuid(number).pw_name}"
    except KeyError:
        return f"user {number}"
