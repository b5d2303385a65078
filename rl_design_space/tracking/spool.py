"""What waits to be written to a tracking store, durable on a local disk."""

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

from filelock import FileLock

from rl_design_space.tracking.address import StoreAddress

#: Kinds of records, in the order in which they have to be delivered: a sweep begins, its points come, stored points
#: join studies, a sweep ends, what dead processes have left is closed.
OPEN, POINT, STUDIES, CLOSE, TIDY = KINDS = ("open", "point", "studies", "close", "tidy")
_RECORD, _STORE = ".record", "store.json"
#: Seconds after which a file that somebody has begun to write is taken for left behind.
_ABANDONED = 3600


class DamagedRecordError(Exception):
    """A record that is not what was written."""


@dataclass(frozen=True)
class Record:
    """Something to be told to a tracking store, complete in itself.

    Attributes:
        kind: one of `KINDS`.
        key: fingerprint of the point, or id of the sweep.
        content: plain values, see who delivers them.
        files: by name.
    """

    kind: str
    key: str
    content: Mapping[str, Any]
    files: Mapping[str, bytes] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Of the file that holds it; sorts by kind, in the order of delivery."""
        return f"{KINDS.index(self.kind)}-{self.kind}-{self.key}{_RECORD}"


class Spool:
    """A folder with a file for each record.

    A record is written beside, made durable and then renamed, so it is there wholly or not at all. It is removed when
    the store has it; one that cannot be delivered goes to the folder `aside`.

    Args:
        folder: made if need be.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder.absolute()
        self._aside = self.folder / "aside"

    @classmethod
    def of(cls, root: Path, address: StoreAddress) -> Spool:
        """The spool under a folder whose records go to one store; it remembers which."""
        digest = hashlib.sha256(json.dumps(vars(address), sort_keys=True).encode()).hexdigest()[:12]
        spool = cls(root / digest)
        if not (spool.folder / _STORE).exists():
            spool.folder.mkdir(parents=True, exist_ok=True)
            spool._write(_STORE, json.dumps(vars(address), indent=2).encode())
        return spool

    @classmethod
    def all_under(cls, root: Path) -> list[Spool]:
        """Every spool under a folder."""
        return [cls(path.parent) for path in sorted(root.glob(f"*/{_STORE}"))]

    @property
    def address(self) -> StoreAddress:
        """The store that the records go to."""
        return StoreAddress(**json.loads((self.folder / _STORE).read_text(encoding="utf-8")))

    @property
    def identity(self) -> str:
        """Tells this spool from all others, on other machines too."""
        return f"{platform.node()}:{self.folder}"

    @property
    def lock(self) -> FileLock:
        """Whoever delivers holds it: one process at a time."""
        return FileLock(self.folder / "delivery.lock")

    def waiting(self) -> list[str]:
        """Names of the records, in the order in which they are to be delivered."""
        with os.scandir(self.folder) as entries:
            return sorted(entry.name for entry in entries if entry.name.endswith(_RECORD))

    def has(self, name: str) -> bool:
        """Whether a record of this name is waiting."""
        return (self.folder / name).exists()

    def write(self, record: Record) -> None:
        """Keep a record; it is durable on return.

        Raises:
            OSError: it could not be written; nothing is left of it.
        """
        content = _packed(record)
        self._write(record.name, _digest(content) + content)

    def read(self, name: str) -> Record:
        """A record as it was written; every byte of it is checked.

        Raises:
            DamagedRecordError: it is something else.
            FileNotFoundError: somebody has delivered it.
        """
        digest, content = _split((self.folder / name).read_bytes())
        if digest != _digest(content):
            raise DamagedRecordError("is not what was written")
        try:
            record = _unpacked(content)
        except (KeyError, ValueError) as error:
            raise DamagedRecordError(f"cannot be read: {error}") from error
        if record.name != name:
            raise DamagedRecordError(f"holds {record.name}")
        return record

    def remove(self, name: str) -> None:
        """Forget a record that has been delivered."""
        (self.folder / name).unlink(missing_ok=True)

    def set_aside(self, name: str, why: str) -> None:
        """Keep a record that cannot be delivered out of the way, with the reason beside it."""
        self._aside.mkdir(exist_ok=True)
        place = self._aside / f"{time.time_ns()}-{name}"
        place.with_name(f"{place.name}.why").write_text(f"{why}\n", encoding="utf-8")
        with suppress(FileNotFoundError):  # somebody else has just done so
            (self.folder / name).replace(place)

    def aside(self) -> list[Path]:
        """Records that were set aside, in that order."""
        return [path.with_suffix("") for path in sorted(self._aside.glob("*.why"))]

    def why_aside(self, name: str, since: int = 0) -> str | None:
        """Why a record was set aside, if it was since some time (nanoseconds since 1970)."""
        for path in reversed(self.aside()):
            when, _, record = path.name.partition("-")
            if record == name and int(when) >= since:
                return path.with_name(f"{path.name}.why").read_text(encoding="utf-8").strip()
        return None

    def sweep_up(self) -> None:
        """Remove what processes that were killed had begun to write."""
        for path in self.folder.glob(".*.new"):
            with suppress(FileNotFoundError):
                if time.time() - path.stat().st_mtime > _ABANDONED:
                    path.unlink()

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


def key_of(name: str) -> str:
    """The fingerprint or id in the name of a record."""
    return name.removesuffix(_RECORD).rpartition("-")[2]


def is_summary(name: str) -> bool:
    """Whether a record says that a sweep begins or ends."""
    return any(name.startswith(Record(kind, "", {}).name.removesuffix(_RECORD)) for kind in (OPEN, CLOSE))


def _packed(record: Record) -> bytes:
    """A line of JSON, and the files, one after the other."""
    header = {"kind": record.kind, "key": record.key, "content": record.content}
    sizes = {name: len(content) for name, content in record.files.items()}
    line = json.dumps({**header, "files": sizes}, allow_nan=False)
    return b"".join((line.encode(), b"\n", *record.files.values()))


def _unpacked(packed: bytes) -> Record:
    line, _, rest = packed.partition(b"\n")
    header, files, end = json.loads(line), {}, 0
    for name, size in header["files"].items():
        files[name] = rest[end : (end := end + size)]
    return Record(header["kind"], header["key"], header["content"], files)


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).digest()


def _split(file: bytes) -> tuple[bytes, bytes]:
    """The digest at the beginning of a record's file, and what follows."""
    size = hashlib.sha256().digest_size
    return file[:size], file[size:]


def point_name(fingerprint: str) -> str:
    """Name of the record of a point."""
    return Record(POINT, fingerprint, {}).name
