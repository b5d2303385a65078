"""Files that get into place together: no report is half new and half old."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from shutil import move, rmtree
from tempfile import mkdtemp
from types import FrameType

#: Signals that end a command.
_ENDING = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def together(folder: Path) -> Iterator[Path]:
    """Yield a temporary folder, whose files are moved into a folder when all of them are written.

    After an error or an interrupt, the files that the folder had are unchanged, and nothing temporary is left.

    Args:
        folder: made if it does not exist; the temporary one is inside it, hence on the same file system.
    """
    is_new = not folder.exists()
    folder.mkdir(parents=True, exist_ok=True)
    new = Path(mkdtemp(prefix=".unfinished-", dir=folder))
    try:
        yield new
        with _uninterrupted():
            for path in sorted(new.iterdir()):
                move(path, (folder / path.name).resolve())  # a link of the user's stays one
    finally:
        with _uninterrupted():
            rmtree(new, ignore_errors=True)
            if is_new:
                with suppress(OSError):  # it is not empty
                    folder.rmdir()


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Hold Ctrl-C and SIGTERM back until the end; only the main thread is interrupted by them."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    held: list[int] = []

    def hold(number: int, frame: FrameType | None) -> None:
        held.append(number)

    before = {number: handler for number in _ENDING if (handler := signal.getsignal(number)) is not None}
    for number in before:
        signal.signal(number, hold)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if held:
            signal.raise_signal(held[0])
