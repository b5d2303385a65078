"""The spool: pending records for a tracking store, durable on a local disk."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from uuid import uuid4

from filelock import FileLock

from rl_design_space.tracking.address import StoreAddress

#: Kinds of records, in the order in which they have to be delivered: a sweep begins, its points are recorded, stored
#: points join studies, a sweep ends, runs of dead processes are closed.
OPEN, POINT, STUDIES, CLOSE, TIDY = KINDS = ("open", "point", "studies", "close", "tidy")
#: How the reason begins for which a record is quarantined that the store has refused.
REFUSED = "the store refused it"
_RECORD, _STORE, _IDENTITY = ".record", "store.json", "identity"
#: Seconds after which a temporary file is taken to be abandoned by a process that was killed.
_ABANDONED = 3600


class CorruptedRecordError(Exception):
    """A record whose file does not hold what was written; the message says so in full.

    Args:
        name: of the record.
        reason: the message.
    """

    def __init__(self, name: str, reason: str) -> None:
        super().__init__(reason)
        self.name = name


@dataclass(frozen=True)
class Record:
    """Something to be delivered to a tracking store, complete in itself.

    Attributes:
        kind: one of `KINDS`.
        key: fingerprint of the point, or id of the sweep.
        content: plain values that JSON can hold; `StoreWriter` reads them.
        files: contents of files by name.
        digest: 64 hexadecimal digits that follow from all of it; empty unless the record was read from a spool.
    """

    kind: str
    key: str
    content: Mapping[str, Any]
    files: Mapping[str, bytes] = field(default_factory=dict)
    digest: str = field(default="", compare=False)

    @property
    def name(self) -> str:
        """Name of the file that holds the record; names sort in the order of delivery."""
        return f"{KINDS.index(self.kind)}-{self.kind}-{self.key}{_RECORD}"


class Spool:
    """A folder with a file for each pending record.

    A record is written to a temporary file, synced and renamed, so it is there completely or not at all. It is removed
    when it is delivered. A record that cannot be delivered is quarantined: moved to the folder `aside`.

    Args:
        folder: where the records are.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder.absolute()
        self._quarantine = self.folder / "aside"

    @classmethod
    def of(cls, root: Path, address: StoreAddress, *, create: bool = True) -> Spool:
        """Return the spool of a store under a folder; it is created if missing and remembers its store."""
        digest = hashlib.sha256(json.dumps(vars(address), sort_keys=True).encode()).hexdigest()[:12]
        spool = cls(root / digest)
        if not create:
            return spool
        if not (spool.folder / _STORE).exists():
            spool.folder.mkdir(parents=True, exist_ok=True)
            spool._write(_STORE, json.dumps(vars(address), indent=2).encode())
        spool._ensure_identity()
        return spool

    @classmethod
    def all_under(cls, root: Path) -> list[Spool]:
        """Return every spool under a folder."""
        return [cls(path.parent) for path in sorted(root.glob(f"*/{_STORE}"))]

    @property
    def address(self) -> StoreAddress:
        """The store that the records are delivered to."""
        return StoreAddress(**json.loads((self.folder / _STORE).read_text(encoding="utf-8")))

    @property
    def identity(self) -> str:
        """A name that differs from that of all other spools, and stays the same on another host or in another place."""
        try:
            return (self.folder / _IDENTITY).read_text(encoding="utf-8")
        except FileNotFoundError:
            return self._place

    @property
    def identities(self) -> frozenset[str]:
        """All names of this spool: version 0.1.0 named a spool by its place."""
        return frozenset({self.identity, self._place})

    @property
    def lock(self) -> FileLock:
        """Lock of the process that delivers; there is one at a time."""
        return FileLock(self.folder / "delivery.lock")

    def pending(self) -> list[str]:
        """Return the names of the pending records in the order of delivery."""
        with os.scandir(self.folder) as entries:
            return sorted(entry.name for entry in entries if entry.name.endswith(_RECORD))

    def has(self, name: str) -> bool:
        """Return whether a record of this name is pending."""
        return (self.folder / name).exists()

    def write(self, record: Record) -> None:
        """Write a record; it is durable on return.

        Raises:
            OSError: it could not be written; no part of it remains.
        """
        content = _packed(record)
        self._write(record.name, _digest(content) + content)

    def read(self, name: str) -> Record:
        """Read a record and verify its checksum.

        Raises:
            CorruptedRecordError: the file does not hold the record that was written.
            FileNotFoundError: the record has been delivered.
        """
        digest, content = _split((self.folder / name).read_bytes())
        if digest != _digest(content):
            raise CorruptedRecordError(name, "record is corrupted (checksum mismatch)")
        try:
            record = _unpacked(content, digest.hex())
        except (LookupError, TypeError, ValueError, AttributeError, RecursionError) as error:
            raise CorruptedRecordError(name, f"record is corrupted (cannot be read: {error})") from error
        if record.name != name:
            raise CorruptedRecordError(name, f"record is corrupted (its file holds {record.name})")
        return record

    def remove(self, name: str) -> None:
        """Remove a record that has been delivered."""
        (self.folder / name).unlink(missing_ok=True)

    def quarantine(self, name: str, reason: str) -> None:
        """Move a record that cannot be delivered out of the way, and write the reason beside it."""
        self._quarantine.mkdir(exist_ok=True)
        place = self._quarantine / f"{time.time_ns()}-{name}"
        place.with_name(f"{place.name}.why").write_text(f"{reason}\n", encoding="utf-8")
        with suppress(FileNotFoundError):  # another process has just done so
            (self.folder / name).replace(place)

    def quarantined(self) -> list[Path]:
        """Return the files of the quarantined records, the oldest first."""
        return [path.with_suffix("") for path in sorted(self._quarantine.glob("*.why"))]

    def quarantine_reason(self, name: str, since: int = 0) -> str | None:
        """Return why a record was quarantined; None if it was not.

        Args:
            name: of the record.
            since: ignore earlier quarantines; nanoseconds since 1970.
        """
        for path in reversed(self.quarantined()):
            when, _, record = path.name.partition("-")
            if record == name and int(when) >= since:
                return path.with_name(f"{path.name}.why").read_text(encoding="utf-8").strip()
        return None

    def restore_refused(self) -> int:
        """Make the records pending again that the store has refused; return how many."""
        restored = 0
        for path in self.quarantined():
            why = path.with_name(f"{path.name}.why")
            place = self.folder / path.name.partition("-")[2]
            with suppress(FileNotFoundError):  # another process has just done so
                if why.read_text(encoding="utf-8").startswith(REFUSED) and not place.exists():
                    path.rename(place)
                    why.unlink()
                    restored += 1
        return restored

    def remove_abandoned(self) -> None:
        """Remove temporary files of processes that were killed while they were writing."""
        for path in self.folder.glob(".*.new"):
            with suppress(FileNotFoundError):
                if time.time() - path.stat().st_mtime > _ABANDONED:
                    path.unlink()

    @property
    def _place(self) -> str:
        return f"{platform.node()}:{self.folder}"

    def _ensure_identity(self) -> None:
        path = self.folder / _IDENTITY
        if not path.exists():
            new = path.with_name(f".{_IDENTITY}.{uuid4().hex}.new")
            new.write_text(f"spool-{uuid4().hex}", encoding="utf-8")
            with suppress(FileExistsError):  # of two processes at once, the first one decides
                os.link(new, path)
            new.unlink()

    def _write(self, name: str, content: bytes) -> None:
        new = self.folder / f".{name}.{os.getpid()}.new"
        try:
            with new.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            new.replace(self.folder / name)
        except OSError as error:
            new.unlink(missing_ok=True)
            raise OSError(error.errno, error.strerror, str(self.folder)) from error
        except BaseException:
            new.unlink(missing_ok=True)
            raise
        folder = os.open(self.folder, os.O_RDONLY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


def point_name(fingerprint: str) -> str:
    """Return the name of the record of a point."""
    return Record(POINT, fingerprint, {}).name


def is_point(name: str) -> bool:
    """Return whether a record of this name is that of a point."""
    return _is_kind(name, POINT)


def is_summary(name: str) -> bool:
    """Return whether a record of this name says that a sweep begins or ends."""
    return _is_kind(name, OPEN) or _is_kind(name, CLOSE)


def key_of(name: str) -> str:
    """Return the fingerprint or id in the name of a record."""
    return name.removesuffix(_RECORD).rpartition("-")[2]


def _is_kind(name: str, kind: str) -> bool:
    return name.startswith(Record(kind, "", {}).name.removesuffix(_RECORD))


def _packed(record: Record) -> bytes:
    """Return a line of JSON, followed by the contents of the files one after the other."""
    header = {"kind": record.kind, "key": record.key, "content": record.content}
    sizes = {name: len(content) for name, content in record.files.items()}
    line = json.dumps({**header, "files": sizes}, allow_nan=False)
    return b"".join((line.encode(), b"\n", *record.files.values()))


def _unpacked(packed: bytes, digest: str) -> Record:
    """Return the record, whose writer need not have been this program.

    Raises:
        Exception: of whatever type, if it is not what `_packed` returns.
    """
    line, _, rest = packed.partition(b"\n")
    header, files, end = json.loads(line), {}, 0
    for name, size in header["files"].items():
        if Path(name).name != name or not 0 <= size <= len(rest) - end:
            raise ValueError(f"a file {name!r} of {size!r} bytes")
        files[name] = rest[end : (end := end + size)]
    if header["kind"] not in KINDS or not isinstance(header["key"], str) or not isinstance(header["content"], dict):
        raise ValueError("its kind, key or content is not that of a record")
    return Record(header["kind"], header["key"], header["content"], files, digest)


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).digest()


def _split(file: bytes) -> tuple[bytes, bytes]:
    """Return the digest at the beginning of a record's file, and the rest."""
    size = hashlib.sha256().digest_size
    return file[:size], file[size:]
