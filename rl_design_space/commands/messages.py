"""Error messages on the command line: one message and exit status 2 for errors that a user can fix."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

_FULL_ERROR = "HYDRA_FULL_ERROR"
#: Whether the user asked for tracebacks; read before `shown_as_messages` sets the variable itself.
_TRACEBACKS = os.environ.get(_FULL_ERROR, "0") not in ("", "0")


@contextmanager
def shown_as_messages() -> Iterator[None]:
    """Print errors that a user can fix as one message and exit with status 2; let all other errors pass."""
    # With this variable set, Hydra raises errors instead of printing them and exiting with status 1.
    os.environ[_FULL_ERROR] = "1"
    try:
        yield
    except Exception as error:
        from rl_design_space.config.explain import explain  # imports Hydra and pydantic, which only errors need

        explained = explain(error) or _unavailable(error)
        if _TRACEBACKS or explained is None:
            raise
        print(f"error: {explained}", file=sys.stderr)
        sys.exit(2)


def _unavailable(error: Exception) -> str | None:
    """Return what to report if a tracking store cannot be reached; None if that is not what went wrong."""
    from rl_design_space.tracking.store_errors import StoreUnavailableError

    if not isinstance(error, StoreUnavailableError):
        return None
    return f"the tracking store cannot be reached at the moment: {error}; tracking.uri=URI names another store"
