"""How commands end: one message and exit status 2 for errors that a user can fix, no riddle for a closed output."""

from __future__ import annotations

import errno
import io
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TextIO

from rl_design_space._visible import visible
from rl_design_space.commands.interrupts import CONTINUE, INTERRUPTED

_FULL_ERROR = "HYDRA_FULL_ERROR"
#: Whether the user asked for tracebacks; read before `shown_as_messages` sets the variable itself.
_TRACEBACKS = os.environ.get(_FULL_ERROR, "0") not in ("", "0")
#: Warnings that Python does not show by default.
_HIDDEN = (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning)
#: Errors of a medium that is full or broken.
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
#: Exit status of a command whose output is no longer read, as in `… | head`: that of a process that SIGPIPE ends.
_CLOSED = 141


def tell(message: str) -> None:
    """Print a message to standard error; control characters in it are shown, not sent."""
    print(visible(message), file=sys.stderr, flush=True)


@contextmanager
def shown_as_messages(purpose: str = CONTINUE) -> Iterator[None]:
    """Print errors that a user can fix as one message and exit with status 2; let all other errors pass.

    Characters that the terminal does not know are replaced. If nobody reads the output any more, the command ends
    without a message.

    Args:
        purpose: of running the command again after an interrupt.
    """
    before = os.environ.get(_FULL_ERROR)
    # With this variable set, Hydra raises errors instead of printing them and exiting with status 1.
    os.environ[_FULL_ERROR] = "1"
    _warn_without_raising()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    try:
        try:
            yield
        finally:
            sys.stdout.flush()
    except KeyboardInterrupt:
        sys.exit(_end(f"interrupted; run the same command again {purpose}", INTERRUPTED))
    except BrokenPipeError:
        _discard_output()
        sys.exit(_CLOSED)
    except Exception as error:
        if _TRACEBACKS or (status := _show(error)) is None:
            raise
        sys.exit(status)
    finally:
        if before is None:
            os.environ.pop(_FULL_ERROR, None)
        else:
            os.environ[_FULL_ERROR] = before


def _warn_without_raising() -> None:
    """Undo that warnings are errors, as with PYTHONWARNINGS=error, in this process and those that it starts.

    Libraries warn of their own deprecations; as errors, these would keep a store from being opened.
    """
    if any(option.startswith("error") for option in sys.warnoptions):
        warnings.simplefilter("default")
        for category in _HIDDEN:
            warnings.simplefilter("ignore", category)
        os.environ["PYTHONWARNINGS"] = ",".join(["default", *(f"ignore::{category.__name__}" for category in _HIDDEN)])


def _show(error: Exception) -> int | None:
    """Print an error, and return the exit status; None if the error is ours, and needs a traceback."""
    from rl_design_space.config.explain import explain  # imports Hydra and pydantic, which only errors need
    from rl_design_space.run.outcome import PointFailedError

    if isinstance(error, OSError) and error.errno in _FULL and not error.filename:
        what = "a file under outputs" if _can_be_written(sys.stdout) else "the output"
        return _end(f"error: {what} cannot be written: {error.strerror}", 1)
    if isinstance(error, PointFailedError):
        return _end(f"failed: {error}", 1)
    if isinstance(error, MemoryError):
        return _end(f"error: not enough memory{f': {error}' if str(error) else ''}", 1)
    if explained := explain(error) or _unavailable(error):
        return _end(f"error: {explained}", 2)
    return None


def _end(message: str, status: int) -> int:
    """Print a last message, and return the exit status."""
    with suppress(OSError):
        tell(message)
    return status


def _can_be_written(stream: TextIO) -> bool:
    """Return whether a stream accepts another line; discard what it still holds if not."""
    try:
        os.write(stream.fileno(), b"\n")
    except OSError:
        _discard_output()
        return False
    return True


def _discard_output() -> None:
    """Send what is left of the output nowhere; Python would try to write it when it ends, and complain."""
    with suppress(OSError, ValueError):  # it is no file
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _unavailable(error: Exception) -> str | None:
    """Return what to report if a tracking store cannot be reached; None if that is not what went wrong."""
    from rl_design_space.tracking.store_errors import StoreUnavailableError

    if not isinstance(error, StoreUnavailableError):
        return None
    return f"the tracking store cannot be reached at the moment: {error}; tracking.uri=URI names another store"
