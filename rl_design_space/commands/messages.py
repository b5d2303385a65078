"""Errors on the command line: one message and exit status 2 for those that a user can fix."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

_FULL_ERROR = "HYDRA_FULL_ERROR"
#: Whether the user asked for tracebacks; read before the command line sets the variable itself.
_TRACEBACKS = os.environ.get(_FULL_ERROR, "0") not in ("", "0")


@contextmanager
def shown_as_messages() -> Iterator[None]:
    """Print errors that a user can mend as one message and exit with 2; let all others pass."""
    # With this set, Hydra hands errors on instead of printing them and exiting with 1.
    os.environ[_FULL_ERROR] = "1"
    try:
        yield
    except Exception as error:
        from rl_design_space.config.explain import explain  # Hydra's errors; not needed where nothing fails

        explained = explain(error)
        if _TRACEBACKS or explained is None:
            raise
        print(f"error: {explained}", file=sys.stderr)
        sys.exit(2)
